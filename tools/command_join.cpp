// plait join: makes a store, or the next version of one, of the parts of a plan.

#include <filesystem>
#include <memory>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "join_report.h"
#include "measure.h"
#include "plait/extend/parts.h"
#include "progress.h"

namespace plait {
namespace {

struct JoinArguments {
  std::filesystem::path plan, store;
  JoinOptions options;
};

int run_join(const JoinArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  JoinOptions options = arguments.options;
  ProgressBar bar("join", ProgressUnit::kNone);
  options.progress = [&](const Progress& now) {
    return bar.update(now.done, now.total, now.phase);
  };
  options.warn = [&](const std::string& warning) {
    bar.clear();
    report_warning(warning);
  };
  const JoinResult joined = join_parts(arguments.plan, arguments.store, options, context.backends);
  bar.clear();
  return report_join(joined, arguments.plan, arguments.store, clock.seconds(), context.json);
}

}  // namespace

void add_join_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<JoinArguments>();
  CommandLine* command = program.add_subcommand("join", "Make a store of the parts of a plan");
  command->add_option("PLAN", arguments->plan, "The plan")->required();
  add_output_option(*command, "STORE", arguments->store,
                    "The store to make, a directory; of a pass, its store")
      ->required();
  command->add_flag("--verify", arguments->options.verify,
                    "Read every block first and compare the digests");
  command->add_flag("--concat", arguments->options.concat,
                    "Copy the parts into levels in one piece, as plait subdivide makes them");
  command->add_flag("--force", arguments->options.replace,
                    "Replace STORE if it is a store, when the new store is complete");
  add_size_option(*command, "--memory", arguments->options.budget_bytes,
                  "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The files of the parts get a second name in STORE (hard links), so no byte is copied; "
      "where\n"
      "that cannot be, they are copied. Such a store can be read, not changed. PLAN stays, and "
      "can\n"
      "be removed afterwards.\n"
      "\n"
      "The parts of a pass become the next version of STORE, the store that was planned. Readers "
      "keep\n"
      "the version that they have open. The last line is the digest of the attribute that the "
      "pass\n"
      "makes. --force and --concat are refused; plait convert makes a store in one piece.\n"
      "\n"
      "If parts are missing or damaged, the command prints them as a list for an array job, such\n"
      "as 3,17-19, and its exit status is 4. The last line is otherwise the digest of STORE.\n"
      "\n"
      "Examples:\n"
      "  plait join molecule.plan molecule.plait\n"
      "  sbatch --array=\"$(plait join statue.plan statue.plait)\" statue.sh    the missing parts\n"
      "  plait join statue.plan statue.plait --concat --verify\n"
      "  plait join smooth1.plan statue.plait                                  the next version");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_join(*arguments, context); };
  });
}

}  // namespace plait
