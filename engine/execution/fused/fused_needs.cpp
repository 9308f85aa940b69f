#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "execution/fused/fused_faces.h"
#include "execution/fused/fused_schedule.h"
#include "execution/fused/half_layout.h"
#include "execution/fused/half_pool.h"
#include "paging/frame_pool.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/fused.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

namespace {

FaceId first_face(const Edge& edge) {
  return edge.is_border() ? edge.own.face() : std::min(edge.own.face(), edge.other.face());
}

/// The first edge of `here` that no face before this one uses, or the end. Edges are numbered by
/// the first face that uses them, and the executor takes faces from the last to the first. So a run
/// completes the edges that it uses first, and it begins its other edges.
EdgeId first_edge_after(const Topology& mesh, EdgeRange here, std::uint64_t face) {
  const auto edges = mesh.edges.subspan(here.first, here.after - here.first);
  const auto is_used_before = [&](const Edge& edge) { return first_face(edge) < face; };
  return here.first +
         static_cast<EdgeId>(std::ranges::partition_point(edges, is_used_before) - edges.begin());
}

/// The same as below for any mesh: a face under way is the first to use at most its three edges.
std::uint64_t most_frame_bytes(std::span<const LevelGeometry> geometries,
                               std::uint64_t faces_under_way) {
  std::uint64_t bytes = 0;
  for (const LevelGeometry& geometry : geometries) {
    const std::uint64_t slots = geometry.slot_count(0);
    const std::uint64_t blocks =
        std::min(geometry.block_count(), (3 * faces_under_way + slots - 2) / slots + 1);
    bytes += blocks * FramePool::frame_bytes(geometry.max_block_bytes());
  }
  return bytes;
}

}  // namespace

std::uint64_t fused_frame_bytes(const Store& store, std::span<const std::size_t> record_bytes,
                                int finest_level, int threads) {
  const int levels = relative_to_base(finest_level, store.base_level()).refinements;
  const std::uint64_t run_faces = FusedSchedule::run_faces(levels);
  const std::uint64_t faces_under_way = run_faces * FusedSchedule::runs_ahead(threads);
  const EdgeRange here = StoreAccess::edges(store);
  std::vector<LevelGeometry> geometries;
  for (const std::size_t bytes : record_bytes)
    for (int level = store.base_level() + 1; level <= finest_level; ++level)
      geometries.push_back(StoreAccess::geometry(store, bytes, level));
  if (StoreAccess::takes_pieces(store)) return most_frame_bytes(geometries, faces_under_way);
  const Topology mesh = store.base().topology();
  std::uint64_t most = 0, after = mesh.faces.size();
  if (here.first == here.after) return 0;
  // No run that begins above the last face, or ends below the first one, has an edge of the range.
  const std::uint64_t last = first_face(mesh.edges[here.after - 1]),
                      lowest = first_face(mesh.edges[here.first]);
  if (after > last + faces_under_way + 1)
    after -= (after - last - faces_under_way - 1) / run_faces * run_faces;
  for (; after > lowest; after -= std::min(after, run_faces)) {
    const std::uint64_t first = after - std::min(after, faces_under_way);
    const EdgeId first_edge = first_edge_after(mesh, here, first),
                 edge_after = first_edge_after(mesh, here, after);
    if (first_edge == edge_after) continue;
    std::uint64_t bytes = 0;
    for (const LevelGeometry& geometry : geometries)
      bytes += (geometry.block_of(edge_after - 1) - geometry.block_of(first_edge) + 1) *
               FramePool::frame_bytes(geometry.max_block_bytes());
    most = std::max(most, bytes);
  }
  return most;
}

std::vector<std::size_t> fused_record_bytes(const Store& store, const FusedPass& pass) {
  std::vector<std::size_t> record_bytes;
  for (const AttributeId id : pass.outputs)
    record_bytes.push_back(store.attributes()[id].schema.record_bytes());
  return record_bytes;
}

Needs fused_needs(const Store& store, const FusedPass& pass, int threads) {
  return fused_needs(store, fused_record_bytes(store, pass), pass.finest_level, threads);
}

Needs fused_needs(const Store& store, std::span<const std::size_t> record_bytes, int finest_level,
                  int threads) {
  const int levels = relative_to_base(finest_level, store.base_level()).refinements;
  if (StoreAccess::takes_pieces(store))  // a piece is chosen with the halves that wait at its cut
    return {fused_frame_bytes(store, record_bytes, finest_level, threads),
            HalfLayout::table_bytes(record_bytes, levels)};
  const Topology mesh = store.base().topology();
  const std::size_t half_bytes = HalfLayout::half_bytes(record_bytes, levels);
  const std::uint64_t faces_under_way =
      FusedSchedule::run_faces(levels) * FusedSchedule::runs_ahead(threads);
  const EdgeRange here = StoreAccess::edges(store);
  const FusedFaces faces(mesh, here, FusedSchedule::run_faces(levels), threads);

  std::uint64_t under_way = 0, most_under_way = 0;
  std::vector<bool> waits(here.after - here.first);  // [edge] one of its halves is made
  for (const FaceId face : faces.all())
    for (const EdgeId edge : mesh.face_edges[face]) {
      // A border edge has only one half, so it never waits.
      if (edge < here.first || edge >= here.after || mesh.edges[edge].is_border()) continue;
      const auto at = edge - here.first;
      waits[at] = !waits[at];
      under_way += waits[at] ? std::uint64_t{1} : ~std::uint64_t{0};
      most_under_way = std::max(most_under_way, under_way);
    }
  // Each of these edges has one waiting half. Threads that are ahead of others may begin more.
  const std::uint64_t most_halves =
      most_under_way + 3 * std::min<std::uint64_t>(faces_under_way, faces.all().size());
  return {fused_frame_bytes(store, record_bytes, finest_level, threads),
          HalfPool::bytes(half_bytes, most_halves) + HalfLayout::table_bytes(record_bytes, levels)};
}

PLAIT_END_NAMESPACE
