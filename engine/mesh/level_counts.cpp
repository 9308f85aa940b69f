#include <fmt/format.h>

#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

LevelCounts counts_at_level(const BaseMesh& mesh, int level) {
  if (level < 0 || level > kMaxLevel)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("count elements: expected a level from 0 to {}, found {}", kMaxLevel, level));
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
