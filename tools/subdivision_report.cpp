#include "subdivision_report.h"

#include <fmt/format.h>

#include "arguments.h"
#include "base/byte_text.h"
#include "rounding_report.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

Json mesh_json(const MeshFigures& mesh) {
  return {{"vertices", mesh.vertices},
          {"edges", mesh.edges},
          {"faces", mesh.faces},
          {"border_edges", mesh.border_edges}};
}

Json paging_json(const PagingStatistics& paging) {
  return {{"blocks_read", paging.blocks_read},
          {"bytes_read", paging.bytes_read},
          {"blocks_written", paging.blocks_written},
          {"bytes_written", paging.bytes_written},
          {"blocks_prefetched", paging.blocks_prefetched},
          {"blocks_evicted", paging.blocks_evicted},
          {"read_waits", paging.read_waits},
          {"read_wait_seconds", 1e-9 * static_cast<double>(paging.read_wait_ns)},
          {"write_waits", paging.write_waits},
          {"write_wait_seconds", 1e-9 * static_cast<double>(paging.write_wait_ns)},
          {"peak_frame_bytes", paging.peak_frame_bytes}};
}

std::string mesh_text(const MeshFigures& mesh) {
  return fmt::format("{} vertices, {} edges ({} border), {} faces", format_count(mesh.vertices),
                     format_count(mesh.edges), format_count(mesh.border_edges),
                     format_count(mesh.faces));
}

Json counts_json(const std::vector<LevelCounts>& counts) {
  Json json = Json::array();
  for (std::size_t level = 0; level < counts.size(); ++level)
    json.push_back({{"level", level},
                    {"vertices", counts[level].vertices},
                    {"edges", counts[level].edges},
                    {"faces", counts[level].faces}});
  return json;
}

}  // namespace

Json to_json(const SubdivisionReport& report) {
  const SubdivisionResult& result = report.result;
  const SubdivisionPlan& plan = result.plan;
  const LevelCounts& finest = plan.level_counts.back();
  Json json = {{"mesh", report.mesh.string()},
               {"store", result.store.empty() ? Json(nullptr) : Json(result.store.string())},
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
               {"seconds", report.seconds},
               {"import_seconds", result.import_seconds},
               {"layout_seconds", result.layout_seconds},
               {"refine_seconds", result.refine_seconds},
               {"commit_seconds", result.commit_seconds},
               {"cpu_seconds", report.cpu_seconds},
               {"ns_per_vertex", result.ns_per_vertex()},
               {"bytes_written", result.paging.bytes_written},
               {"bytes_read", result.paging.bytes_read},
               {"read_wait_seconds", 1e-9 * static_cast<double>(result.paging.read_wait_ns)},
               {"write_wait_seconds", 1e-9 * static_cast<double>(result.paging.write_wait_ns)},
               {"stored_bytes", result.stored_bytes},
               {"peak_rss_bytes", report.peak_rss_bytes},
               {"base_mesh_bytes", result.base_mesh_bytes},
               {"budget_bytes", plan.store.budget_bytes},
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
               {"span", result.spans.loop.span},
               {"face_span", result.spans.face.span},
               {"paging", paging_json(result.paging)}};
  for (const auto& [name, rounding] : result.roundings) json["max_error"][name] = to_json(rounding);
  if (!result.digest.empty()) {
    json["digest"] = result.digest;
    json["digest_seconds"] = result.digest_seconds;
  }
  return json;
}

std::string to_text(const SubdivisionReport& report) {
  const SubdivisionResult& result = report.result;
  const SubdivisionPlan& plan = result.plan;
  const LevelCounts& finest = plan.level_counts.back();
  std::string text = fmt::format("input      {}\n", mesh_text(plan.input));
  if (plan.base_level > 0)
    text += fmt::format("base       {}, refined {} times in memory\n", mesh_text(result.base),
                        plan.base_level);
  text += fmt::format("level {:<2}   {} vertices, {} edges, {} faces\n", plan.subdivide.levels,
                      format_count(finest.vertices), format_count(finest.edges),
                      format_count(finest.faces));
  text += fmt::format("method     {}{}{}, {}, executor {}, {} thread{}\n",
                      to_string(plan.subdivide.scheme),
                      plan.subdivide.limit ? " with limit positions" : "",
                      plan.subdivide.normals ? " with normals" : "", to_string(plan.precision),
                      to_string(plan.subdivide.executor), plan.subdivide.threads,
                      plan.subdivide.threads == 1 ? "" : "s");
  text += fmt::format("layout     {}, span {} edges\n", to_string(plan.layout),
                      format_count(result.spans.loop.span));
  text += fmt::format(
      "time       {:.2f} s: import {:.2f}, layout {:.2f}, refine {:.2f}, commit {:.2f}{}; {:.1f} "
      "ns "
      "per vertex; {:.2f} s of processor time\n",
      report.seconds, result.import_seconds, result.layout_seconds, result.refine_seconds,
      result.commit_seconds,
      result.digest.empty() ? "" : fmt::format(", digest {:.2f}", result.digest_seconds),
      result.ns_per_vertex(), report.cpu_seconds);
  text +=
      fmt::format("moved      {} written, {} read, {} stored by backend {}\n",
                  format_bytes(result.paging.bytes_written), format_bytes(result.paging.bytes_read),
                  format_bytes(result.stored_bytes), plan.store.backend);
  text += fmt::format("backend    {}: {}\n", plan.store.backend, plan.backend_reason);
  text += fmt::format("memory     {} at most; budget {}, base mesh {}\n",
                      format_bytes(report.peak_rss_bytes), format_bytes(plan.store.budget_bytes),
                      format_bytes(result.base_mesh_bytes));
  for (const auto& [name, rounding] : result.roundings)
    text += fmt::format("rounded    {}: {}\n", name, to_text(rounding));
  if (!result.digest.empty()) text += fmt::format("digest     {}\n", result.digest);
  return text;
}

}  // namespace plait
