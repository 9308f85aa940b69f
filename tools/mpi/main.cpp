// The program plait-mpi: makes the parts of a plan in one MPI job, and joins them.
#include <fmt/format.h>

#include <cstdlib>
#include <exception>
#include <optional>
#include <string>

#include "argument_text.h"
#include "command_line/command_line.h"
#include "console.h"
#include "interrupt.h"
#include "mpi/job.h"
#include "mpi/ranks.h"
#include "plait/error.h"
#include "plait/extend/plugins.h"
#include "plait/version.h"

namespace plait::mpi {
namespace {

constexpr const char* kFooter =
    "Each rank makes one part after another: rank 0 hands them out, and makes some itself. At the\n"
    "end rank 0 joins them, if STORE is given. If a part fails, its rank says so, and all go on\n"
    "with other parts; another rank tries the part once more, and a rank whose parts fail three\n"
    "times in a row makes no more. The same command again makes the parts that are not done. All\n"
    "ranks must see PLAN. Ranks that wait sleep.\n"
    "\n"
    "PLAIT_PLUGINS names more plug-ins, with colons between them.\n"
    "Exit status: 0 done; 1 failed; 2 bad usage or refused input; 3 try again (I/O, no space,\n"
    "busy); 4 parts are missing, which are printed as a list such as 3,17-19; 128 + N cancelled "
    "by\n"
    "signal N.\n"
    "\n"
    "Examples:\n"
    "  plait plan statue.ply statue.plan --levels 8 --parts 1000\n"
    "  mpiexec -n 64 plait-mpi statue.plan statue.plait\n"
    "  srun --ntasks 64 plait-mpi statue.plan --threads 4";

void add_options(CommandLine& program, JobOptions& arguments) {
  program.version(std::string("plait-mpi ") + PLAIT_VERSION);
  program.add_option("PLAN", arguments.plan, "The plan")->required();
  program.add_option("STORE", arguments.store,
                     "The store to make of the parts, a directory; default: only the parts");
  program
      .add_parsed_option(
          "--threads",
          [&](const std::string& text) {
            arguments.part.threads = static_cast<int>(parse_whole_number(text, 1, 1024));
          },
          "Threads that compute, in each rank; default 1")
      ->type_name("N");
  program
      .add_parsed_option(
          "--memory",
          [&](const std::string& text) { arguments.part.budget_bytes = parse_size(text); },
          "Budget for blocks in memory, of each rank")
      ->type_name("SIZE");
  program
      .add_option("--plugin", arguments.plugins,
                  "Load a plug-in, a shared library (may be repeated)")
      ->type_name("FILE")
      ->allow_extra_args(false);
  program.add_flag("--json", arguments.json,
                   "Print one JSON object, and nothing else, to standard output");
  program.help_column(30);
  program.footer(kFooter);
}

int run_job(const JobOptions& arguments, const std::optional<std::string>& bad_usage) {
  Plugins plugins;
  Job job(arguments, plugins.backends());
  int rank = 0;
  try {
    {
      const Ranks ranks;
      install_signal_handlers();
      rank = ranks.rank();
      if (bad_usage) {
        if (rank == 0) report_error("usage", *bad_usage, arguments.json);
        return kExitRefused;
      }
      job.run(ranks, [&] {
        if (const char* const list = ::secure_getenv("PLAIT_PLUGINS")) plugins.load_list(list);
        for (const std::string& file : arguments.plugins) plugins.load(file);
      });
    }
    const int status = job.end();
    flush_output();
    return status;
  } catch (const Error& error) {
    report_error(to_string(error.code()),
                 rank == 0 ? error.what()
                           : fmt::format("rank {} on {}: {}", rank, host_name(), error.what()),
                 arguments.json && rank == 0);
    return exit_status_with_plan(error, arguments.plan);
  }
}

int run_program(int argument_count, char** words) {
  JobOptions arguments;
  CommandLine program("Make the parts of a plan in an MPI job, and join them", "plait-mpi");
  add_options(program, arguments);
  std::optional<std::string> bad_usage;
  try {
    if (program.parse(argument_count, words) == CommandLine::Outcome::kAnswered) {
      print(program.answer());
      flush_output();
      return kExitDone;
    }
  } catch (const UsageError& stopped) {
    bad_usage = std::string(stopped.what()) + " (see plait-mpi --help)";
  }
  return run_job(arguments, bad_usage);
}

}  // namespace
}  // namespace plait::mpi

int main(int argument_count, char** words) {
  try {
    return plait::mpi::run_program(argument_count, words);
  } catch (const std::exception& error) {
    plait::report_error("internal", error.what(), false);
    return plait::kExitFailed;
  }
}
