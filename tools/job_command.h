// tools/job_command.h: the command of a job. Its options, their order and their --help are those of
// the job (plait/job.h).
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "command.h"
#include "command_line/command_line.h"
#include "plait/job.h"

namespace plait {

struct JobCommand {
  std::string job;     ///< its name, and that of the command
  std::string footer;  ///< of --help
  /// What the command prints of the report.
  std::function<std::string(const nlohmann::ordered_json& report)> text;
  /// For a job whose error has a report: prints it, and returns the exit status.
  std::function<int(const nlohmann::ordered_json& report, bool json)> failed = {};
  /// The option that names a plan, for commands that a scheduler starts: their errors have the exit
  /// statuses of exit_status_with_plan().
  std::string plan_option = {};
  /// The command's name and options, where they are not those of the job.
  std::optional<JobDescription> described = {};
  /// What the job gets for options that the command line does not give.
  JobOptions unless_given = {};
};

/// Adds the command, with --json and --plugin. Values are checked when the command line is parsed,
/// as far as that needs no plug-in.
void add_job_command(CommandLine& program, CommandContext& context, JobCommand command);

/// Runs a job as its command does, with a progress bar, warnings, and signals that end it. Returns
/// the report.
nlohmann::ordered_json run_with_progress(const std::string& job, const JobOptions& options,
                                         const CommandContext& context);

}  // namespace plait
