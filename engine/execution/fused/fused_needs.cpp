#include <algorithm>
#include <vector>

#include "execution/fused/fused_levels.h"
#include "execution/fused/fused_schedule.h"
#include "execution/fused/half_layout.h"
#include "execution/fused/half_pool.h"
#include "paging/frame_pool.h"
#include "plait/fused.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

FusedNeeds fused_needs(const Store& store, const FusedPass& pass, int threads) {
  const Topology mesh = store.base().topology();
  const int levels = fused_levels(store, pass);
  const std::size_t half_bytes = HalfLayout::half_bytes(store, pass.outputs, levels);
  const std::uint64_t run_faces = FusedSchedule::run_faces(levels);
  const std::uint64_t faces_under_way = run_faces * FusedSchedule::runs_ahead(threads);

  // Edges are numbered by the first face that uses them, and the executor takes faces from the last
  // to the first. So a run completes the edges that it uses first, and it begins its other edges.
  std::vector<EdgeId> edges_before(mesh.faces.size() + 1, 0);
  for (FaceId face = 0; face < mesh.faces.size(); ++face) {
    EdgeId after = edges_before[face];
    for (const EdgeId edge : mesh.face_edges[face]) after = std::max(after, edge + 1);
    edges_before[face + 1] = after;
  }

  FusedNeeds needs;
  std::uint64_t under_way = 0, most_under_way = 0;
  const EdgeSet& half = store.base().slot_shapes().half();
  for (FaceId face = static_cast<FaceId>(mesh.faces.size()); face-- > 0;) {
    const EdgeId first_new = edges_before[face];
    // A border edge has only one half, so it never waits.
    const std::uint64_t ends = edges_before[face + 1] - first_new -
                               (half.rank(edges_before[face + 1]) - half.rank(first_new));
    for (const EdgeId edge : mesh.face_edges[face]) under_way += edge < first_new ? 1 : 0;
    most_under_way = std::max(most_under_way, under_way);
    under_way -= ends;
  }
  // Each of these edges has one waiting half. Threads that are ahead of others may begin more.
  const std::uint64_t most_halves =
      most_under_way + 3 * std::min<std::uint64_t>(faces_under_way, mesh.faces.size());
  needs.slot_bytes = HalfPool::bytes(half_bytes, most_halves) +
                     HalfLayout::table_bytes(store, pass.outputs, levels);

  std::vector<LevelGeometry> geometries;
  for (const AttributeId id : pass.outputs)
    for (int level = 1; level <= levels; ++level)
      geometries.emplace_back(store.base().slot_shapes(), BaseRelativeLevel(level),
                              store.attributes()[id].schema.record_bytes(),
                              store.options().block_bytes);
  for (std::uint64_t after = mesh.faces.size(); after > 0; after -= std::min(after, run_faces)) {
    const EdgeId first_edge = edges_before[after - std::min(after, faces_under_way)],
                 edge_after = edges_before[after];
    if (first_edge == edge_after) continue;
    std::uint64_t bytes = 0;
    for (const LevelGeometry& geometry : geometries)
      bytes += (geometry.block_of(edge_after - 1) - geometry.block_of(first_edge) + 1) *
               FramePool::frame_bytes(geometry.max_block_bytes());
    needs.frame_bytes = std::max(needs.frame_bytes, bytes);
  }
  return needs;
}

PLAIT_END_NAMESPACE
