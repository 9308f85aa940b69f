// The jobs "part" and "join".
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "job_rules.h"
#include "parts/part_tables.h"
#include "plait/error.h"
#include "plait/extend/parts.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct PartArguments : PartOptions {
  std::filesystem::path plan, list;
  std::uint32_t part = 0, offset = 0;
};

struct JoinArguments : JoinOptions {
  std::filesystem::path plan, store, missing_to;
};

/// The number in this line of a file, the first line being 0.
std::uint32_t number_in_list(const std::filesystem::path& list, std::uint32_t line) {
  std::ifstream file(list);
  if (!file) throw Error(ErrorCode::kNotFound, fmt::format("open {}: no such list", list.native()));
  std::string text;
  for (std::uint32_t at = 0; std::getline(file, text); ++at)
    if (at == line) return static_cast<std::uint32_t>(parse_whole_number(text, 0, 1 << 20));
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("part {} of {}: the list has fewer lines", line, list.native()));
}

void write_list(const std::filesystem::path& path, const JoinResult& joined, const Warn& warn) {
  std::vector<std::uint32_t> all;
  std::ranges::merge(joined.missing, joined.bad, std::back_inserter(all));
  std::string text;
  for (const std::uint32_t part : all) text += std::to_string(part) + "\n";
  make_new_file(path, Existing::kReplace, warn, [&](UnpublishedFile& file) {
    file.file().write_at(0, std::as_bytes(std::span(text)));
  });
}

JobReport run_part(PartArguments& arguments, const JobCall& call) {
  if (call.watch.before_files) call.watch.before_files();
  arguments.progress = call.watch.progress;
  arguments.parallel_for = call.parallel_for;
  arguments.warn = call.watch.warn;
  std::uint32_t part = arguments.part + arguments.offset;
  if (!arguments.list.empty()) part = number_in_list(arguments.list, part);
  const PartResult done = make_part(arguments.plan, part, arguments, call.backends);
  return {{"plan", arguments.plan.string()},
          {"part", part},
          {"was_done", done.was_done},
          {"bytes", done.bytes},
          {"digest", done.digest}};
}

struct StatusArguments {
  std::filesystem::path plan;
};

JobReport run_status(StatusArguments& arguments, const JobCall&) {
  const PlanStatus status = status_of_plan(arguments.plan);
  using State = PartStatus::State;
  JobReport parts = JobReport::array();
  for (std::size_t number = 0; number < status.parts.size(); ++number) {
    const PartStatus& part = status.parts[number];
    if (part.state == State::kWaiting) continue;
    JobReport one = {{"part", number}};
    one["state"] = part.state == State::kDone   ? "done"
                   : part.state == State::kLost ? "lost"
                                                : "running";
    one["host"] = part.host;
    one["begun"] = part.begun;
    if (part.state == State::kDone) {
      one["user"] = part.user;
      one["seconds"] = part.seconds;
      one["cpu_seconds"] = part.cpu_seconds;
      one["peak_memory_bytes"] = part.peak_memory_bytes;
    } else {
      one["changed"] = part.changed;
    }
    parts.push_back(std::move(one));
  }
  std::vector<std::uint32_t> missing;
  for (std::uint32_t number = 0; number < status.parts.size(); ++number)
    if (const State state = status.parts[number].state;
        state == State::kWaiting || state == State::kLost)
      missing.push_back(number);
  JobReport report = {{"plan", arguments.plan.string()},
                      {"part_count", status.parts.size()},
                      {"done", status.done},
                      {"running", status.running},
                      {"lost", status.lost},
                      {"waiting", status.waiting},
                      {"bytes_done", status.bytes_done},
                      {"bytes_per_second", status.bytes_per_second}};
  if (status.seconds_left) report["seconds_left"] = *status.seconds_left;
  report["array"] = array_text(missing);
  report["parts"] = std::move(parts);
  return report;
}

/// Errors: a JobError with the lists, if parts are missing or damaged.
JobReport run_join(JoinArguments& arguments, const JobCall& call) {
  if (call.watch.before_files) call.watch.before_files();
  arguments.progress = call.watch.progress;
  arguments.warn = call.watch.warn;
  const JoinResult joined = join_parts(arguments.plan, arguments.store, arguments, call.backends);
  if (!arguments.missing_to.empty()) write_list(arguments.missing_to, joined, call.watch.warn);
  if (!joined.has_store) {
    if (call.watch.warn)
      for (const std::string& reason : joined.reasons) call.watch.warn(reason);
    const JobReport report = {{"plan", arguments.plan.string()},
                              {"missing", joined.missing},
                              {"bad", joined.bad},
                              {"array", joined.again()}};
    throw JobError(ErrorCode::kBadState,
                   fmt::format("join {}: parts {} are missing or damaged", arguments.plan.native(),
                               joined.again()),
                   {}, report.dump(-1, ' ', false, JobReport::error_handler_t::replace));
  }
  JobReport report = {{"plan", arguments.plan.string()},
                      {"store", arguments.store.string()},
                      {"version", joined.version}};
  if (!joined.digest.empty()) report["digest"] = joined.digest;
  report["was_joined"] = joined.was_joined;
  return report;
}

}  // namespace

Job part_job() {
  JobTable<PartArguments> table("part", "Make one part of a plan");
  table.path("plan", &PartArguments::plan, "The plan").at(0).required();
  table.count("part", &PartArguments::part, 0, 1 << 20, "The part, from 0 on").at(1).required();
  table.count("offset", &PartArguments::offset, 0, 1 << 20,
              "Add this to PART: for arrays that a site keeps short");
  table.path("list", &PartArguments::list,
             "Take PART as the number of a line of this file, from 0 on, which has the part");
  table.flag("again", &PartArguments::again, "Make the part even if it is done");
  table.path("store", &PartArguments::store,
             "Of a pass: where this machine sees its store; default: the path in the plan");
  table.bytes("memory", &PartArguments::budget_bytes, "Budget for blocks in memory");
  table.threads(&PartArguments::threads, "Threads that compute");
  return table.run(run_part);
}

Job status_job() {
  JobTable<StatusArguments> table("status", "Say how far a plan is");
  table.path("plan", &StatusArguments::plan, "The plan").at(0).required();
  return table.run(run_status);
}

Job join_job() {
  JobTable<JoinArguments> table("join", "Make a store of the parts of a plan");
  table.path("plan", &JoinArguments::plan, "The plan").at(0).required();
  table
      .output("output", &JoinArguments::store,
              "The store to make, a directory; of a pass, its store")
      .at(1)
      .required();
  table.flag("verify", &JoinArguments::verify, "Read every block first and compare the digests");
  table.flag("concat", &JoinArguments::concat,
             "Copy the parts into levels in one piece, as plait subdivide makes them");
  table.path("missing-to", &JoinArguments::missing_to,
             "Write the parts that are missing or damaged to a file, one a line, for part --list");
  table.force(&JoinArguments::existing);
  table.bytes("memory", &JoinArguments::budget_bytes, "Budget for blocks in memory");
  return table.run(run_join);
}

PLAIT_END_NAMESPACE
