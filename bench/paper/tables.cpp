#include "paper/tables.h"

#include <string>

#include "plait/layout.h"

namespace plait::paper {
namespace {

using nlohmann::json;

json shares_of(const BaseMesh& mesh, int levels) {
  json rows = json::array();
  for (const LevelShare& share : base_edge_shares(mesh, levels))
    rows.push_back(
        {{"level", share.level}, {"born", share.born}, {"on_base_edges", share.on_base_edges}});
  return rows;
}

json spans_of(const BaseMesh& mesh) {
  json rows = json::array();
  for (const LayoutKind kind :
       {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm}) {
    const LayoutSpans spans = lay_out(mesh, kind).spans;
    rows.push_back({{"layout", to_string(kind)},
                    {"face", spans.face.span},
                    {"loop", spans.loop.span},
                    {"loop_median", spans.loop.median_width}});
  }
  return rows;
}

}  // namespace

std::vector<LevelShare> base_edge_shares(const BaseMesh& mesh, int levels) {
  const std::uint64_t border = mesh.border_edge_count(), inner = mesh.edge_count() - border;
  std::vector<LevelShare> shares;
  for (int level = 1; level <= levels; ++level) {
    const std::uint64_t n = std::uint64_t{1} << (level - 1);
    shares.push_back({level, inner * n * n + border * (n * (n + 1) / 2), mesh.edge_count() * n});
  }
  return shares;
}

std::uint64_t replicated_vertices(const BaseMesh& mesh, int level) {
  const std::uint64_t side = std::uint64_t{1} << level;
  return mesh.face_count() * ((side + 1) * (side + 2) / 2);
}

json mesh_tables(const BaseMesh& mesh, int levels) {
  json counts = json::array(), replicated = json::array();
  for (int level = 0; level <= levels; ++level) {
    counts.push_back(counts_at_level(mesh, level).vertices);
    replicated.push_back(replicated_vertices(mesh, level));
  }
  return {{"vertices", mesh.vertex_count()},
          {"edges", mesh.edge_count()},
          {"faces", mesh.face_count()},
          {"border_edges", mesh.border_edge_count()},
          {"euler", static_cast<std::int64_t>(mesh.vertex_count() + mesh.face_count()) -
                        static_cast<std::int64_t>(mesh.edge_count())},
          {"counts", std::move(counts)},
          {"replicated", std::move(replicated)},
          {"shares", shares_of(mesh, levels)},
          {"spans", spans_of(mesh)}};
}

}  // namespace plait::paper
