// bench/bench_commands.h: the commands of `plait bench` that need records only. Each is in
// command_bench_NAME.cpp.
#pragma once

#include "command.h"

namespace plait {

void add_bench_report_command(CommandLine& bench, CommandContext& context);
void add_bench_compare_command(CommandLine& bench, CommandContext& context);

}  // namespace plait
