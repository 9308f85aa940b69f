#include "plait/detail/face_depths.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The shapes at a level that the faces with at least this depth have.
SlotShapes shapes_at(const Topology& mesh, std::span<const std::uint8_t> depths, int level) {
  const auto has = [&](FaceSide side) { return side.exists() && depths[side.face()] >= level; };
  std::vector<EdgeId> half, absent;
  for (EdgeId edge = 0; edge < mesh.edges.size(); ++edge) {
    const bool own = has(mesh.edges[edge].own), other = has(mesh.edges[edge].other);
    if (own != other) half.push_back(edge);
    if (!own && !other) absent.push_back(edge);
  }
  return {mesh.edges.size(), EdgeSet(half), EdgeSet(absent)};
}

}  // namespace

FaceDepths::FaceDepths(const Topology& mesh, std::vector<std::uint8_t> depths)
    : depths_(std::move(depths)) {
  if (depths_.size() != mesh.faces.size())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("set the depths of faces: expected {} depths, one for each face, found "
                            "{}",
                            mesh.faces.size(), depths_.size()));
  for (std::size_t face = 0; face < depths_.size(); ++face) {
    if (depths_[face] > kMaxLevel)
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("set the depths of faces: face {}: expected 0 to {} refinements, "
                              "found {}",
                              face, kMaxLevel, depths_[face]));
    deepest_ = std::max<int>(deepest_, depths_[face]);
    shallowest_ = std::min<int>(shallowest_, depths_[face]);
  }
  // Up to the shallowest depth, the levels are those of a mesh without depths and share their sets.
  const SlotShapes all(mesh);
  for (int level = 1; level <= deepest_ + 1; ++level)
    shapes_.push_back(level <= shallowest_ ? all : shapes_at(mesh, depths_, level));
}

const SlotShapes& FaceDepths::shapes(BaseRelativeLevel level) const noexcept {
  return shapes_[static_cast<std::size_t>(std::clamp(level.refinements, 1, deepest_ + 1) - 1)];
}

std::uint64_t FaceDepths::memory_bytes() const noexcept {
  std::uint64_t bytes = depths_.size();
  for (std::size_t at = 0; at < shapes_.size(); ++at)
    if (static_cast<int>(at) >= shallowest_) bytes += shapes_[at].memory_bytes();
  return bytes;
}

PLAIT_END_NAMESPACE
