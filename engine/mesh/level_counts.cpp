#include <fmt/format.h>

#include <algorithm>

#include "plait/base_mesh.h"
#include "plait/detail/drawn_triangles.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/level_geometry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// What is drawn of faces with depths of their own. The surface is closed as the base mesh is, so
/// the Euler number gives the edges.
LevelCounts drawn_counts(const BaseMesh& mesh, int level) {
  const FaceDepths& depths = *mesh.depths();
  const Topology topology = mesh.topology();
  const auto depth = [&](FaceId face) { return std::min(level, depths.of(face)); };
  LevelCounts counts{mesh.vertex_count(), 0, 0};
  for (int finer = 1; finer <= std::min(level, depths.deepest()); ++finer)
    counts.vertices += mesh.geometry(BaseRelativeLevel(finer), 1, 1).total_bytes();
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    counts.faces += drawn_depths(topology, face, depth).triangle_count();
  counts.edges =
      counts.vertices + counts.faces - mesh.vertex_count() - mesh.face_count() + mesh.edge_count();
  return counts;
}

}  // namespace

LevelCounts counts_at_level(const BaseMesh& mesh, int level) {
  if (level < 0 || level > kMaxLevel)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("count elements: expected a level from 0 to {}, found {}", kMaxLevel, level));
  if (mesh.depths() != nullptr) return drawn_counts(mesh, level);
  LevelCounts counts{mesh.vertex_count(), mesh.edge_count(), mesh.face_count()};
  for (int l = 0; l < level; ++l) {
    LevelCounts next{};
    std::uint64_t new_inner_edges = 0;
    if (__builtin_add_overflow(counts.vertices, counts.edges, &next.vertices) ||
        __builtin_mul_overflow(counts.faces, 4u, &next.faces) ||
        __builtin_mul_overflow(counts.faces, 3u, &new_inner_edges) ||
        __builtin_mul_overflow(counts.edges, 2u, &next.edges) ||
        __builtin_add_overflow(next.edges, new_inner_edges, &next.edges))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("count elements: expected counts below 2^64, found more at level {} "
                              "of a mesh of {} faces",
                              l + 1, mesh.face_count()));
    counts = next;
  }
  return counts;
}

PLAIT_END_NAMESPACE
