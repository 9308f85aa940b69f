// bench/bench_commands.h: the commands of `plait bench` that need records only. Each is in
// command_bench_NAME.cpp.
#pragma once

#include <filesystem>
#include <string>

#include "bench/findings.h"
#include "bench/read_runs.h"
#include "command.h"
#include "plait/partial_output.h"

namespace plait {

void add_bench_report_command(CommandLine& bench, CommandContext& context);
void add_bench_compare_command(CommandLine& bench, CommandContext& context);

/// Writes the page of a report. `command` is what the page says that it was made by. Errors:
/// kInvalidArgument if the name is taken and `existing` is kRefuse; kIo, kNoSpace.
void write_report_page(const std::filesystem::path& path, Existing existing,
                       const bench::RunSet& set, const bench::Findings& findings,
                       const std::string& command);

}  // namespace plait
