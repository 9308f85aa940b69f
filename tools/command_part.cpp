// plait part: makes one part of a plan.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "console.h"
#include "json_text.h"
#include "measure.h"
#include "plait/extend/parts.h"
#include "progress.h"

namespace plait {
namespace {

struct PartArguments {
  std::filesystem::path plan;
  int part = 0, offset = 0;
  PartOptions options;
};

int run_part(const PartArguments& arguments, const CommandContext& context) {
  PartOptions options = arguments.options;
  ProgressBar bar("part", ProgressUnit::kNone);
  options.progress = [&](const Progress& now) {
    return bar.update(now.done, now.total, now.phase);
  };
  const auto part = static_cast<std::uint32_t>(arguments.part + arguments.offset);
  const PartResult done = make_part(arguments.plan, part, options, context.backends);
  bar.clear();
  if (!context.json) {
    print(done.was_done ? fmt::format("part {}: it is done already\n", part)
                        : fmt::format("part {}: {}, {:.3g} s\n", part, format_bytes(done.bytes),
                                      done.seconds));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {{"plan", arguments.plan.string()},
                                         {"part", part},
                                         {"was_done", done.was_done},
                                         {"bytes", done.bytes},
                                         {"digest", done.digest},
                                         {"seconds", done.seconds},
                                         {"peak_rss_bytes", peak_rss_bytes()}};
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_part_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<PartArguments>();
  arguments->options.threads = default_thread_count();
  CommandLine* command = program.add_subcommand("part", "Make one part of a plan");
  command->add_option("PLAN", arguments->plan, "The plan")->required();
  add_whole_option(*command, "PART", arguments->part, 0, 1 << 20, "The part, from 0 on")
      ->required();
  add_whole_option(*command, "--offset", arguments->offset, 0, 1 << 20,
                   "Add this to PART: for arrays that a site keeps short");
  command->add_flag("--again", arguments->options.again, "Make the part even if it is done");
  add_size_option(*command, "--memory", arguments->options.budget_bytes,
                  "Budget for blocks in memory");
  add_threads_option(*command, arguments->options.threads, "Threads that compute");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "A part writes only into a directory of its own in PLAN, and at the end the file done.PART\n"
      "gets its name. So a part that was killed is simply started again, and a part that two\n"
      "machines make at once does no harm. A part of a pass reads its store and does not change "
      "it;\n"
      "passes of a program of your own are made by that program (plait/extend/parts.h).\n"
      "\n"
      "Examples:\n"
      "  plait part molecule.plan 0\n"
      "  plait part statue.plan \"$SLURM_ARRAY_TASK_ID\" --offset 1000");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_part(*arguments, context); };
  });
}

}  // namespace plait
