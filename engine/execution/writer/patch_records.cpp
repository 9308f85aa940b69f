#include "execution/writer/patch_records.h"

#include <cstring>

#include "address/record_sizes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void copy_any(const PatchRecords& patch, int from, const std::array<bool, 3>& with_edge,
              const FaceSlots& slots) {
  const std::int64_t size = patch.size();
  const std::byte* next = patch.records;
  for (std::int64_t j = 0; j <= size; ++j)
    for (std::int64_t i = 0; i + j <= size; ++i, next += patch.record_bytes) {
      if (is_corner(patch.level, i, j) || to_side(patch.level, i, j).level < from) continue;
      const bool left_out = (i + j == size && !with_edge[0]) || (i == 0 && !with_edge[1]) ||
                            (j == 0 && !with_edge[2]);
      if (!left_out) std::memcpy(slots.find(patch.level, i, j), next, patch.record_bytes);
    }
}

}  // namespace

void copy_inside(const PatchRecords& patch, int from, const std::array<bool, 3>& with_edge,
                 const FaceSlots& slots) {
  const bool copied = with_record_size(patch.record_bytes, [&](auto record) {
    slots.copy_from(from, patch.level, with_edge,
                    reinterpret_cast<const decltype(record)*>(patch.records));
  });
  if (!copied) copy_any(patch, from, with_edge, slots);
}

void copy_own_corners(const PatchRecords& patch, const Topology& mesh, FaceId face,
                      const FaceSlots& slots) {
  for (int corner = 0; corner < 3; ++corner) {
    const VertexId vertex = mesh.faces[face][static_cast<std::size_t>(corner)];
    if (mesh.vertex_corners[vertex].face() != face) continue;
    const FaceIndex at = corner_point(face, patch.level, corner);
    std::memcpy(slots.find(patch.level, at.i, at.j), patch.at(at.i, at.j), patch.record_bytes);
  }
}

PLAIT_END_NAMESPACE
