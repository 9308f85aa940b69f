// The job "subdivide".
#include <fmt/format.h>

#include "job.h"
#include "job_rules.h"
#include "option_text.h"
#include "plait/extend/edge_index.h"
#include "plait/subdivision_job.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct SubdivideArguments : SubdivisionRequest {
  std::vector<std::string> compress, max_error;
};

JobReport mesh_json(const MeshFigures& mesh) {
  return {{"vertices", mesh.vertices},
          {"edges", mesh.edges},
          {"faces", mesh.faces},
          {"border_edges", mesh.border_edges}};
}

double seconds_of(std::uint64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

JobReport paging_json(const PagingStatistics& paging) {
  return {{"blocks_read", paging.blocks_read},
          {"bytes_read", paging.bytes_read},
          {"blocks_written", paging.blocks_written},
          {"bytes_written", paging.bytes_written},
          {"blocks_prefetched", paging.blocks_prefetched},
          {"blocks_evicted", paging.blocks_evicted},
          {"read_waits", paging.read_waits},
          {"read_wait_seconds", seconds_of(paging.read_wait_ns)},
          {"write_waits", paging.write_waits},
          {"write_wait_seconds", seconds_of(paging.write_wait_ns)},
          {"peak_frame_bytes", paging.peak_frame_bytes}};
}

JobReport counts_json(const std::vector<LevelCounts>& counts) {
  JobReport json = JobReport::array();
  for (std::size_t level = 0; level < counts.size(); ++level)
    json.push_back({{"level", level},
                    {"vertices", counts[level].vertices},
                    {"edges", counts[level].edges},
                    {"faces", counts[level].faces}});
  return json;
}

/// Of a base mesh that is taken in pieces, spans are not measured.
JobReport span_json(const SubdivisionPlan& plan, std::uint64_t span) {
  return plan.piece_bytes != 0 ? JobReport(nullptr) : JobReport(span);
}

JobReport report_of(const std::filesystem::path& mesh, const SubdivisionResult& result) {
  const SubdivisionPlan& plan = result.plan;
  const LevelCounts& finest = plan.level_counts.back();
  JobReport json = {
      {"mesh", mesh.string()},
      {"store", result.store.empty() ? JobReport(nullptr) : JobReport(result.store.string())},
      {"input", mesh_json(plan.input)},
      {"merged_vertices", plan.merged_vertices},
      {"seam_vertices", plan.seam_vertices},
      {"base", mesh_json(result.base)},
      {"base_level", plan.base_level},
      {"levels", plan.subdivide.levels},
      {"resumed_level", result.resumed_level},
      {"vertices", finest.vertices},
      {"edges", finest.edges},
      {"faces", finest.faces},
      {"level_counts", counts_json(plan.level_counts)},
      {"import_seconds", result.import_seconds},
      {"layout_seconds", result.layout_seconds},
      {"refine_seconds", result.refine_seconds},
      {"commit_seconds", result.commit_seconds},
      {"ns_per_vertex", result.ns_per_vertex()},
      {"bytes_written", result.paging.bytes_written},
      {"bytes_read", result.paging.bytes_read},
      {"read_wait_seconds", seconds_of(result.paging.read_wait_ns)},
      {"write_wait_seconds", seconds_of(result.paging.write_wait_ns)},
      {"stored_bytes", result.stored_bytes},
      {"base_mesh_bytes", result.base_mesh_bytes},
      {"budget_bytes", plan.store.budget_bytes + plan.piece_bytes},
      {"piece_bytes", plan.piece_bytes},
      {"block_bytes", plan.store.block_bytes},
      {"backend", plan.store.backend},
      {"backend_reason", plan.backend_reason},
      {"pipelines", result.pipelines},
      {"durability", plan.store.durability == Durability::kCommit ? "commit" : "none"},
      {"executor", to_string(plan.subdivide.executor)},
      {"threads", plan.subdivide.threads},
      {"scheme", to_string(plan.subdivide.scheme)},
      {"precision", to_string(plan.precision)},
      {"normals", plan.subdivide.normals},
      {"limit", plan.subdivide.limit},
      {"layout", to_string(plan.layout)},
      {"span", span_json(plan, result.spans.loop.span)},
      {"face_span", span_json(plan, result.spans.face.span)},
      {"paging", paging_json(result.paging)}};
  if (!result.faces_of_level.empty()) {
    json["from_vertices"] = finest.vertices;
    json["from_faces"] = finest.faces;
    json["vertices"] = result.drawn.vertices;
    json["edges"] = result.drawn.edges;
    json["faces"] = result.drawn.faces;
    json["vertex_share"] =
        static_cast<double>(result.drawn.vertices) / static_cast<double>(finest.vertices);
    json["depths"] = depths_json(result.faces_of_level);
    json["distance"] = result.distance;
    json["prune_seconds"] = result.prune_seconds;
  }
  for (const auto& [name, rounding] : result.roundings)
    json["max_error"][name] = rounding_json(rounding);
  if (!result.digest.empty()) {
    json["digest"] = result.digest;
    json["digest_seconds"] = result.digest_seconds;
  }
  return json;
}

SubdivisionRequest request_of(SubdivideArguments& arguments, const Compression& compression,
                              const JobCall& call) {
  arguments.max_errors = error_bounds_of(arguments.max_error);
  arguments.pipeline_of =
      pipelines_of(compression, !arguments.max_errors.empty(), arguments.backend, call.backends);
  arguments.parallel_for = call.parallel_for;
  return arguments;
}

JobReport run_subdivide(SubdivideArguments& arguments, const JobCall& call) {
  const std::filesystem::path mesh = std::get<std::filesystem::path>(arguments.mesh);
  const Compression compression = compression_of(arguments.compress);
  SubdivisionJob job(request_of(arguments, compression, call), call.backends);
  compression.check_levels(job.plan().base_level, arguments.levels);
  check_attributes_of_scheme(compression, arguments.normals);
  if (call.watch.warn)
    for (const std::string& warning : job.plan().warnings) call.watch.warn(warning);
  try {
    const SubdivisionResult result = job.run(call.watch);
    JobReport report = report_of(mesh, result);
    // Who opens the store has all base records in memory. Pieces have no blocks that are made.
    report["made_blocks"] = result.plan.piece_bytes != 0
                                ? JobReport::array()
                                : made_blocks_json(result.store, call.backends);
    return report;
  } catch (const JobError&) {
    throw;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled || !job.plan().commits_levels) throw;
    throw JobError(error, error.what(), "resume");
  }
}

void add_surface_options(JobTable<SubdivideArguments>& table) {
  table
      .count("levels", &SubdivideArguments::levels, 1, kMaxLevel,
             fmt::format("The level to reach, 1 to {}", kMaxLevel))
      .required();
  table.named(
      "scheme",
      [](SubdivideArguments& arguments, const std::string& name) {
        arguments.scheme = scheme_from_name(name);
      },
      fmt::format("{}; default {}", scheme_names(), to_string(Scheme())));
  table.precision(
      &SubdivideArguments::precision,
      "Type of the positions; auto: float32, unless it moves a vertex of INPUT by more than a "
      "thousandth of the shortest edge there");
  table.weld(&SubdivideArguments::weld);
  table.flag("normals", &SubdivideArguments::normals, "Also compute unit normals");
  table
      .named(
          "max-distance",
          [](SubdivideArguments& arguments, const std::string& text) {
            const RelativeLength length = parse_relative_length(text);
            arguments.distance_in_diagonals = length.is_percent;
            arguments.max_distance = length.is_percent ? length.number / 100 : length.number;
          },
          "Faces keep their levels up to a depth of their own, with which the finest level and "
          "what is drawn are at most D from each other: a length, or with % a part of the diagonal")
      .shown_as("D[%]");
  table.flag("limit", &SubdivideArguments::limit,
             fmt::format("Project positions to the limit surface ({})", limit_scheme_names()));
}

void add_storage_options(JobTable<SubdivideArguments>& table) {
  table.text("backend", &SubdivideArguments::backend,
             "The backend that stores the levels (see below); default auto");
  table.compress(&SubdivideArguments::compress);
  table.max_error(&SubdivideArguments::max_error);
  table.named(
      "layout",
      [](SubdivideArguments& arguments, const std::string& name) {
        arguments.layout = layout_from_name(name);
      },
      "Order of edges on disk: auto (chosen by the executor; default), given, spatial, hilbert or "
      "rcm");
  table.bytes("block", &SubdivideArguments::block_bytes, std::string(kBlockHelp));
  table.bytes("max-slot", &SubdivideArguments::max_slot_bytes,
              fmt::format("Largest slot of positions: refine the base mesh in memory until all "
                          "slots fit; default {}",
                          size_text(kLargestSlotBytes)));
  table.flag("no-index", &SubdivideArguments::no_index, std::string(kNoIndexHelp));
  table
      .choice(
          "durability", {"commit", "none"},
          [](SubdivideArguments& arguments, const std::string& name) {
            arguments.durability = name == "commit" ? Durability::kCommit : Durability::kNone;
          },
          "commit: wait until the store is on the disk; none: do not wait (temporary stores)")
      .by_default("commit");
}

void add_run_options(JobTable<SubdivideArguments>& table) {
  table.bytes(
      "memory", &SubdivideArguments::budget_bytes,
      "Budget for blocks in memory; half of it for pieces of a mesh of plait layout that is "
      "larger");
  table.threads(&SubdivideArguments::threads, "Threads that compute");
  table
      .named(
          "executor",
          [](SubdivideArguments& arguments, const std::string& name) {
            arguments.executor = executor_from_name(name);
          },
          "auto (fused; with --resume sweep), fused, sweep or transparent")
      .by_default(std::string(to_string(SubdivisionRequest().executor)));
  table.flag("verify", &SubdivideArguments::verify,
             "With --max-error: read the rounded levels back and compare every record with the "
             "exact one, before the exact levels go");
  table.flag("digest", &SubdivideArguments::digest,
             "Also read all levels at the end and print their digest, as plait digest does");
  table
      .flag("ignore-size", &SubdivideArguments::ignore_size,
            "Start even if memory or disk are too small for the last level")
      .remedy("starts anyway");
  table.force(&SubdivideArguments::existing);
  table
      .flag("resume", &SubdivideArguments::resume,
            "Make OUTPUT under its final name and commit every level; if OUTPUT exists, continue "
            "from its last commit (after an interruption, or to reach a finer level)")
      .remedy("continues from the last commit");
}

}  // namespace

Job subdivide_job() {
  JobTable<SubdivideArguments> table("subdivide", "Refine a mesh into a store");
  table
      .path("input", &SubdivideArguments::mesh,
            "PLY, OBJ, OFF or STL, also .gz and .zst; or what plait layout made")
      .at(0)
      .required();
  table
      .output("output", &SubdivideArguments::store,
              "The store to make, a directory; may be omitted with --backend memory")
      .at(1);
  add_surface_options(table);
  add_storage_options(table);
  add_run_options(table);
  return table.run(run_subdivide);
}

PLAIT_END_NAMESPACE
