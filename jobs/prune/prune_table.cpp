// The job "prune".
#include "job.h"
#include "job_rules.h"
#include "prune/prune.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct PruneArguments : PruneRequest {
  std::vector<std::string> compress;
};

JobReport run_prune(PruneArguments& arguments, const JobCall& call) {
  arguments.copy.compression = compression_of(arguments.compress);
  arguments.copy.parallel_for = call.parallel_for;
  const PruneResult done = prune(arguments, call.open_backends, call.backends, call.watch);
  JobReport report = {{"from", arguments.copy.from.string()},
                      {"store", done.copy.store.string()},
                      {"depths", depths_json(done.faces_of_level)},
                      {"raised_faces", done.raised},
                      {"from_vertices", done.from_vertices},
                      {"vertices", done.copy.vertices},
                      {"vertex_share", static_cast<double>(done.copy.vertices) /
                                           static_cast<double>(done.from_vertices)},
                      {"backend", done.copy.options.backend},
                      {"backend_reason", done.copy.backend_reason},
                      {"from_stored_bytes", done.copy.from_stored_bytes},
                      {"stored_bytes", done.copy.stored_bytes}};
  if (done.tolerance) report["max_distance"] = *done.tolerance;
  if (done.distance) report["distance"] = *done.distance;
  return report;
}

}  // namespace

Job prune_job() {
  JobTable<PruneArguments> table(
      "prune",
      "Copy a store with fewer levels where fewer are enough: each face has its own depth");
  const auto copy = [](auto member) {
    return [member](PruneArguments & arguments) -> auto& { return arguments.copy.*member; };
  };
  table.path("input", copy(&ConversionRequest::from), "The store to copy").at(0).required();
  table.output("output", copy(&ConversionRequest::to), "The store to make").at(1).required();
  table
      .named(
          "max-distance",
          [](PruneRequest& request, const std::string& text) {
            request.max_distance = parse_relative_length(text);
          },
          "Faces are so deep that the finest level and what is drawn are at most D from each "
          "other: "
          "a length, or with % a part of the diagonal")
      .shown_as("D[%]");
  table.count("vertices", &PruneArguments::vertices, 1, std::uint64_t{1} << 62,
              "At most N vertices are left: those with which the distance is smallest");
  table
      .text("depth-by", &PruneArguments::depth_by,
            "The face attribute that has the finest level of each face")
      .shown_as("FACE_ATTRIBUTE");
  table.count("balance", &PruneArguments::balance, 0, kMaxLevel,
              "Make faces deeper until neighbours differ by at most N levels; 0: leave them");
  table.text("backend", copy(&ConversionRequest::backend),
             "The backend of the copy (see below); auto: chosen by its size; default: as in INPUT");
  table.compress(&PruneArguments::compress);
  table.bytes("block", copy(&ConversionRequest::block_bytes), std::string(kBlockOfCopyHelp));
  table.flag("no-index", copy(&ConversionRequest::no_index), std::string(kNoIndexHelp));
  table.bytes(
      "memory", copy(&ConversionRequest::budget_bytes),
      "Budget for blocks in memory; half of it for the source, or less where it needs less");
  table.force(copy(&ConversionRequest::existing));
  return table.run(run_prune);
}

PLAIT_END_NAMESPACE
