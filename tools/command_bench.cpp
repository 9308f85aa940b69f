// plait bench: measures backends on disks. This file has `plait bench list`, and chooses between
// the other commands.

#include "command_bench.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "json_text.h"
#include "runs/workloads.h"

namespace plait {
namespace {

int run_list(const CommandContext& context) {
  nlohmann::ordered_json workloads, backends;
  for (const bench::Workload& workload : bench::workloads())
    workloads[std::string(workload.name)] = workload.summary;
  for (const std::string& name : context.backends.names())
    backends[name] = context.backends.find(name).summary;
  if (context.json) {
    print(json_text(nlohmann::ordered_json{{"workloads", workloads}, {"backends", backends}}));
    return kExitDone;
  }
  for (const auto& [title, entries] :
       {std::pair{"Workloads", &workloads}, {"Backends", &backends}}) {
    print(fmt::format("{}:\n", title));
    for (const auto& [name, summary] : entries->items())
      print(fmt::format("  {:<22}{}\n", name, summary.get<std::string>()));
  }
  return kExitDone;
}

}  // namespace

void add_bench_command(CommandLine& program, CommandContext& context) {
  const auto quick = std::make_shared<bool>(false);
  CommandLine* command =
      program.add_subcommand("bench", "Measure backends on disks, with floors and proofs");
  command->add_flag("--quick", *quick,
                    "Compare all backends in two minutes; the options below are for it");
  const std::function<int()> run_quick = add_bench_quick_options(*command, context);
  add_bench_run_command(*command, context);
  CommandLine* const list = command->add_subcommand("list", "List the workloads and the backends");
  add_plugin_option(*list, context);
  add_json_option(*list, context);
  list->callback([&context] { context.run = [&context] { return run_list(context); }; });
  add_bench_floors_command(*command, context);
  add_bench_report_command(*command, context);
  add_bench_compare_command(*command, context);
  command->footer(
      "docs/backends.md has advice, and docs/measuring.md explains reports and records. --quick\n"
      "writes records beside its page; after Ctrl-C, page and verdict are of what there is.\n"
      "\n"
      "Examples:\n"
      "  plait bench --quick /mnt/nvme /mnt/share\n"
      "  plait bench run --dir /mnt/nvme --workload sweep-read,build --out runs.jsonl --dry-run\n"
      "  plait bench report runs.jsonl --html report.html\n"
      "  plait bench compare main.jsonl branch.jsonl");
  command->callback([quick, run_quick, &context] {
    if (context.run) return;  // a command of its own
    if (!*quick)
      throw UsageError(
          "no command was given: expected --quick, run, list, floors, report or compare");
    context.run = run_quick;
  });
}

}  // namespace plait
