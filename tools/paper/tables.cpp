#include "paper/tables.h"

#include <string>

#include "paper/base_edge_share.h"
#include "plait/layout.h"

namespace plait::paper {
namespace {

using nlohmann::json;

json shares_of(const BaseMesh& mesh, int levels, std::uint64_t most_counted) {
  int counted_levels = 0;
  while (counted_levels < levels &&
         counts_at_level(mesh, counted_levels + 1).vertices <= most_counted)
    ++counted_levels;
  const std::vector<LevelShare> counted = count_base_edge_shares(mesh, counted_levels);
  json rows = json::array();
  for (const LevelShare& share : base_edge_shares(mesh, levels)) {
    json row = {
        {"level", share.level}, {"born", share.born}, {"on_base_edges", share.on_base_edges}};
    if (share.level <= counted_levels) {
      const LevelShare& found = counted[static_cast<std::size_t>(share.level - 1)];
      row["counted_born"] = found.born;
      row["counted_on_base_edges"] = found.on_base_edges;
    }
    rows.push_back(std::move(row));
  }
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

json mesh_tables(const BaseMesh& mesh, int levels, std::uint64_t most_counted) {
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
          {"shares", shares_of(mesh, levels, most_counted)},
          {"spans", spans_of(mesh)}};
}

}  // namespace plait::paper
