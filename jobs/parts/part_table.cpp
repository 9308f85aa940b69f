// The jobs "part" and "join".
#include <fmt/format.h>

#include "parts/part_tables.h"
#include "plait/extend/parts.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct PartArguments : PartOptions {
  std::filesystem::path plan;
  std::uint32_t part = 0, offset = 0;
};

struct JoinArguments : JoinOptions {
  std::filesystem::path plan, store;
};

JobReport run_part(PartArguments& arguments, const JobCall& call) {
  if (call.watch.before_files) call.watch.before_files();
  arguments.progress = call.watch.progress;
  arguments.parallel_for = call.parallel_for;
  const std::uint32_t part = arguments.part + arguments.offset;
  const PartResult done = make_part(arguments.plan, part, arguments, call.backends);
  return {{"plan", arguments.plan.string()},
          {"part", part},
          {"was_done", done.was_done},
          {"bytes", done.bytes},
          {"digest", done.digest}};
}

/// Errors: a JobError with the lists, if parts are missing or damaged.
JobReport run_join(JoinArguments& arguments, const JobCall& call) {
  if (call.watch.before_files) call.watch.before_files();
  arguments.progress = call.watch.progress;
  arguments.warn = call.watch.warn;
  const JoinResult joined = join_parts(arguments.plan, arguments.store, arguments, call.backends);
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
  return {{"plan", arguments.plan.string()},
          {"store", arguments.store.string()},
          {"version", joined.version},
          {"digest", joined.digest},
          {"was_joined", joined.was_joined}};
}

}  // namespace

Job part_job() {
  JobTable<PartArguments> table("part", "Make one part of a plan");
  table.path("plan", &PartArguments::plan, "The plan").at(0).required();
  table.count("part", &PartArguments::part, 0, 1 << 20, "The part, from 0 on").at(1).required();
  table.count("offset", &PartArguments::offset, 0, 1 << 20,
              "Add this to PART: for arrays that a site keeps short");
  table.flag("again", &PartArguments::again, "Make the part even if it is done");
  table.bytes("memory", &PartArguments::budget_bytes, "Budget for blocks in memory");
  table.threads(&PartArguments::threads, "Threads that compute");
  return table.run(run_part);
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
  table.force(&JoinArguments::existing);
  table.bytes("memory", &JoinArguments::budget_bytes, "Budget for blocks in memory");
  return table.run(run_join);
}

PLAIT_END_NAMESPACE
