#include "execution/writer/shared_vertices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "execution/writer/record_text.h"
#include "plait/error.h"
#include "plait/extend/base_relative_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void SharedVertices::write(const PatchRecords& patch, FaceId face, int from,
                           const FaceSlots& slots) {
  compare(patch, face, from, slots);
  const auto copy = [&](std::int64_t i, std::int64_t j) {
    std::memcpy(slots.find(patch.level, i, j), patch.at(i, j), patch.record_bytes);
  };
  for (int corner = 0; from == 0 && corner < 3; ++corner) {
    const FaceIndex at = corner_point(face, patch.level, corner);
    copy(at.i, at.j);
    has_vertex_[mesh_->faces[face][static_cast<std::size_t>(corner)]] = true;
  }
  for (int born = std::max(from, 1); born <= patch.level; ++born)
    for (int side = 0; side < 3; ++side) for_each_on_side(patch, side, born, copy);
}

void SharedVertices::compare(const PatchRecords& patch, FaceId face, int from,
                             const FaceSlots& slots) const {
  const auto compare_at = [&](FaceId other, std::int64_t i, std::int64_t j) {
    const std::byte* const found = slots.find(patch.level, i, j);
    if (std::memcmp(found, patch.at(i, j), patch.record_bytes) != 0)
      refuse(patch, face, other, i, j, found);
  };
  for (int corner = 0; from == 0 && corner < 3; ++corner)
    if (has_vertex_[mesh_->faces[face][static_cast<std::size_t>(corner)]]) {
      const FaceIndex at = corner_point(face, patch.level, corner);
      compare_at(kNoId, at.i, at.j);
    }
  for (int born = std::max(from, 1); born <= patch.level; ++born)
    for (int side = 0; side < 3; ++side) {
      const FaceSide across = mesh_->across(FaceSide(face, side));
      if (across.exists() && attribute_->is_written(across.face(), born))
        for_each_on_side(patch, side, born,
                         [&](std::int64_t i, std::int64_t j) { compare_at(across.face(), i, j); });
    }
}

void SharedVertices::refuse(const PatchRecords& patch, FaceId face, FaceId other, std::int64_t i,
                            std::int64_t j, const std::byte* found) const {
  if (other == kNoId) {  // one of the faces around the corner
    const auto is_other = [&](FaceId each) {
      return each != face && attribute_->is_written(each, 0);
    };
    const FaceSide first =
        mesh_->vertex_corners[mesh_->faces[face][static_cast<std::size_t>(corner_of(i, j))]];
    FaceSide at = first;
    while (at.exists() && !is_other(at.face())) {
      at = mesh_->next_corner(at);
      if (at == first) break;
    }
    other = at.exists() && is_other(at.face()) ? at.face() : face;
  }
  const AttributeSchema& schema = attribute_->schema();
  const auto text = [&](const std::byte* record) {
    return record_text(schema, {record, patch.record_bytes});
  };
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("write face {} of '{}' at level {}: the record at ({}, {}) is {}, and face {} "
                  "has written {} there",
                  face, schema.name, level_number(BaseRelativeLevel(patch.level), base_level_), i,
                  j, text(patch.at(i, j)), other, text(found)));
}

PLAIT_END_NAMESPACE
