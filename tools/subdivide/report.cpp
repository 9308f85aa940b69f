#include "subdivide/report.h"

#include <fmt/format.h>

#include "arguments.h"

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

}  // namespace

MeshFigures figures_of(const BaseMesh& mesh) {
  return {mesh.vertex_count(), mesh.edge_count(), mesh.face_count(), mesh.border_edge_count()};
}

double SubdivideReport::ns_per_vertex() const {
  const std::uint64_t made = level_counts.back().vertices - level_counts.front().vertices;
  return made == 0 ? 0 : 1e9 * refine_seconds / static_cast<double>(made);
}

Json to_json(const SubdivideReport& report) {
  Json counts = Json::array();
  for (std::size_t level = 0; level < report.level_counts.size(); ++level)
    counts.push_back({{"level", level},
                      {"vertices", report.level_counts[level].vertices},
                      {"edges", report.level_counts[level].edges},
                      {"faces", report.level_counts[level].faces}});
  Json json = {{"mesh", report.mesh.string()},
               {"store", report.store.empty() ? Json(nullptr) : Json(report.store.string())},
               {"input", mesh_json(report.input)},
               {"base", mesh_json(report.base)},
               {"base_level", report.base_level},
               {"levels", report.levels},
               {"resumed_level", report.resumed_level},
               {"vertices", report.level_counts.back().vertices},
               {"edges", report.level_counts.back().edges},
               {"faces", report.level_counts.back().faces},
               {"level_counts", std::move(counts)},
               {"seconds", report.seconds},
               {"import_seconds", report.import_seconds},
               {"layout_seconds", report.layout_seconds},
               {"refine_seconds", report.refine_seconds},
               {"commit_seconds", report.commit_seconds},
               {"cpu_seconds", report.cpu_seconds},
               {"ns_per_vertex", report.ns_per_vertex()},
               {"bytes_written", report.paging.bytes_written},
               {"bytes_read", report.paging.bytes_read},
               {"read_wait_seconds", 1e-9 * static_cast<double>(report.paging.read_wait_ns)},
               {"write_wait_seconds", 1e-9 * static_cast<double>(report.paging.write_wait_ns)},
               {"stored_bytes", report.stored_bytes},
               {"peak_rss_bytes", report.peak_rss_bytes},
               {"base_mesh_bytes", report.base_mesh_bytes},
               {"budget_bytes", report.budget_bytes},
               {"block_bytes", report.block_bytes},
               {"backend", report.backend},
               {"backend_reason", report.backend_reason},
               {"codec", report.codec},
               {"filter", report.filter},
               {"durability", report.durability},
               {"executor", report.executor},
               {"threads", report.threads},
               {"scheme", report.scheme},
               {"precision", report.precision},
               {"normals", report.normals},
               {"limit", report.limit},
               {"layout", report.layout},
               {"span", report.spans.loop.span},
               {"face_span", report.spans.face.span},
               {"paging", paging_json(report.paging)}};
  if (!report.digest.empty()) {
    json["digest"] = report.digest;
    json["digest_seconds"] = report.digest_seconds;
  }
  return json;
}

std::string to_text(const SubdivideReport& report) {
  const LevelCounts& finest = report.level_counts.back();
  std::string text = fmt::format("input      {}\n", mesh_text(report.input));
  if (report.base_level > 0)
    text += fmt::format("base       {}, refined {} times in memory\n", mesh_text(report.base),
                        report.base_level);
  text += fmt::format("level {:<2}   {} vertices, {} edges, {} faces\n", report.levels,
                      format_count(finest.vertices), format_count(finest.edges),
                      format_count(finest.faces));
  text += fmt::format("method     {}{}{}, {}, executor {}, {} thread{}\n", report.scheme,
                      report.limit ? " to the limit" : "", report.normals ? " with normals" : "",
                      report.precision, report.executor, report.threads,
                      report.threads == 1 ? "" : "s");
  text += fmt::format("layout     {}, span {} edges\n", report.layout,
                      format_count(report.spans.loop.span));
  text += fmt::format(
      "time       {:.2f} s: import {:.2f}, layout {:.2f}, refine {:.2f}, commit {:.2f}{}; {:.1f} "
      "ns "
      "a vertex; {:.2f} s of processors\n",
      report.seconds, report.import_seconds, report.layout_seconds, report.refine_seconds,
      report.commit_seconds,
      report.digest.empty() ? "" : fmt::format(", digest {:.2f}", report.digest_seconds),
      report.ns_per_vertex(), report.cpu_seconds);
  text +=
      fmt::format("moved      {} written, {} read, {} stored by backend {}\n",
                  format_bytes(report.paging.bytes_written), format_bytes(report.paging.bytes_read),
                  format_bytes(report.stored_bytes), report.backend);
  text += fmt::format("backend    {}: {}\n", report.backend, report.backend_reason);
  text += fmt::format("memory     {} at most; budget {}, base mesh {}\n",
                      format_bytes(report.peak_rss_bytes), format_bytes(report.budget_bytes),
                      format_bytes(report.base_mesh_bytes));
  if (!report.digest.empty()) text += fmt::format("digest     {}\n", report.digest);
  return text;
}

}  // namespace plait
