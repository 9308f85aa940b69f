#include "export/drawn_patch.h"

#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// How far a point on a side of a patch is along the side, counterclockwise from its first corner.
std::int64_t along(int side, std::int64_t size, FacePoint point) {
  return side == 2 ? point.i : side == 0 ? point.j : size - point.j;
}

FacePoint point_along(int side, std::int64_t size, std::int64_t steps) {
  if (side == 2) return {steps, 0};
  if (side == 0) return {size - steps, steps};
  return {0, size - steps};
}

}  // namespace

DrawnPatch::DrawnPatch(const Store& store, std::string attribute)
    : attribute_(std::move(attribute)),
      reader_(store, {.attributes = {attribute_}, .policy = EvictionPolicy::kLayoutOrder}),
      mesh_(store.base().topology()),
      base_level_(store.base_level()) {}

DrawnPatch::Read DrawnPatch::read_patch(FaceId face, int refinements) const {
  PatchView patch = reader_.read_patch(face, base_level_ + refinements);
  RecordView records = patch.records(attribute_);
  return {std::move(patch), std::move(records)};
}

void DrawnPatch::read(FaceId face, const DrawnDepths& depths) {
  depths_ = depths;
  own_.reset();
  own_.emplace(read_patch(face, depths.face));
  for (int side = 0; side < 3; ++side) {
    std::optional<Beyond>& beyond = beyond_[static_cast<std::size_t>(side)];
    beyond.reset();
    const int depth = depths.sides[static_cast<std::size_t>(side)];
    if (depth == depths.face) continue;
    const FaceSide across = mesh_.across(FaceSide(face, side));
    beyond.emplace(Beyond{read_patch(across.face(), depth), across.side()});
  }
}

std::span<const std::byte> DrawnPatch::at(FacePoint point) const {
  const int shift = depths_.grid() - depths_.face;
  if (((point.i | point.j) & ((std::int64_t{1} << shift) - 1)) == 0)
    return own_->records.at(point.i >> shift, point.j >> shift);
  const int side = point.j == 0 ? 2 : point.i == 0 ? 1 : 0;
  const int depth = depths_.sides[static_cast<std::size_t>(side)];
  const Beyond& beyond = *beyond_[static_cast<std::size_t>(side)];
  const std::int64_t size = std::int64_t{1} << depth;
  const std::int64_t steps =
      along(side, std::int64_t{1} << depths_.grid(), point) >> (depths_.grid() - depth);
  const FacePoint there = point_along(beyond.side, size, size - steps);
  return beyond.read.records.at(there.i, there.j);
}

PLAIT_END_NAMESPACE
