// plait/detail/face_depths.h: how often each face of a mesh is refined, and the shapes of slots
// that follow from it (docs/adaptive.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/base_relative_level.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// Depths count refinements of the mesh whose faces these are. Immutable; safe from any number of
/// threads.
class FaceDepths {
 public:
  /// Errors: kInvalidArgument unless there is one depth for each face, each at most kMaxLevel.
  FaceDepths(const Topology& mesh, std::vector<std::uint8_t> depths);

  std::span<const std::uint8_t> of_faces() const noexcept { return depths_; }
  int of(FaceId face) const noexcept { return depths_[face]; }
  int deepest() const noexcept { return deepest_; }
  int shallowest() const noexcept { return shallowest_; }
  /// Whether the own face of the edge has this level. Then a half slot of the edge belongs to it.
  bool own_face_has(const Edge& edge, BaseRelativeLevel level) const noexcept {
    return of(edge.own.face()) >= level.refinements;
  }
  /// The shapes of the slots of a level, which is at least 1. Beyond deepest() all are absent.
  const SlotShapes& shapes(BaseRelativeLevel level) const noexcept;
  std::uint64_t memory_bytes() const noexcept;

 private:
  std::vector<std::uint8_t> depths_;
  int deepest_ = 0, shallowest_ = kMaxLevel;
  std::vector<SlotShapes> shapes_;  ///< [level - 1], and then that of absent slots
};

PLAIT_END_NAMESPACE
