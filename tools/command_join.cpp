// plait join: makes a store, or the next version of one, of the parts of a plan.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "console.h"
#include "job_command.h"
#include "json_text.h"
#include "report_text.h"

namespace plait {
namespace {

std::string join_text(const nlohmann::ordered_json& report) {
  const std::string text =
      fmt::format("{}: version {}{}, {:.2f} s\n", report["store"].get<std::string>(),
                  report["version"].get<std::uint64_t>(),
                  report["was_joined"].get<bool>() ? " was joined before" : "",
                  report["seconds"].get<double>());
  return report.contains("digest") ? text + report["digest"].get<std::string>() + "\n" : text;
}

/// The parts that are missing or damaged, as an array job takes them.
int print_incomplete(const nlohmann::ordered_json& report, bool json) {
  print(json ? json_text(report) : report["array"].get<std::string>() + "\n");
  return kExitIncomplete;
}

}  // namespace

void add_join_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"join",
       "The files of the parts get a second name in OUTPUT (hard links), so no byte is copied; "
       "where\n"
       "that cannot be, they are copied. Such a store can be read, not changed. PLAN stays, and "
       "can\n"
       "be removed afterwards.\n"
       "\n"
       "The parts of a pass become the next version of OUTPUT, the store that was planned. Readers "
       "keep\n"
       "the version that they have open. The last line is the digest of the attribute that the "
       "pass\n"
       "makes. --force and --concat are refused; plait convert makes a store in one piece.\n"
       "\n"
       "If parts are missing or damaged, the command prints them as a list for an array job, such\n"
       "as 3,17-19, and its exit status is 4. The last line is otherwise the digest of OUTPUT.\n"
       "Exit status 3: the disk, its room or another process was in the way; try again.\n"
       "\n"
       "If OUTPUT is the store of PLAN already, the command changes nothing, but replaces files "
       "of\n"
       "OUTPUT that are damaged by those of parts that were made again; then not all parts must "
       "be\n"
       "in PLAN, and the digest is only printed with --verify.\n"
       "\n"
       "Examples:\n"
       "  plait join molecule.plan molecule.plait\n"
       "  sbatch --array=\"$(plait join statue.plan statue.plait)\" statue.sh    the missing "
       "parts\n"
       "  plait join statue.plan statue.plait --concat --verify\n"
       "  plait join smooth1.plan statue.plait                                  the next version",
       join_text, print_incomplete, "plan"});
}

}  // namespace plait
