// plait bench: measures backends on disks. Its commands are in command_bench_NAME.cpp.

#include "bench/bench_commands.h"
#include "command.h"

namespace plait {

void add_bench_command(CommandLine& program, CommandContext& context) {
  CommandLine* bench =
      program.add_subcommand("bench", "Measure which backend is best on which disk");
  bench->require_subcommand();
  add_bench_report_command(*bench, context);
  add_bench_compare_command(*bench, context);
  bench->footer(
      "Examples:\n"
      "  plait bench report runs.jsonl --html report.html\n"
      "  plait bench compare main.jsonl branch.jsonl");
}

}  // namespace plait
