// prune/distance_depths.h: how deep faces must be so that a coarser surface is near enough.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "option_text.h"
#include "plait/detail/namespace.h"
#include "plait/job.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct DistanceDepths {
  std::vector<std::uint8_t> depths;  ///< [face] refinements of the base mesh
  std::uint64_t raised = 0;          ///< faces that balance has made deeper
  double tolerance = 0;              ///< as a length
  double distance = 0;               ///< the largest between the finest level and what is drawn
};

/// For each face the smallest depth at which the finest level and what is drawn of the face
/// (plait/detail/drawn_triangles.h) are at most the tolerance from each other (PatchDistance):
/// first with sides as coarse as the face, then, after neighbours were made alike, with their sides
/// as they are. A face that is then too far becomes deeper, until none is. The diagonal is that of
/// the box around the base vertices. Memory: one patch of the finest level, and 9 bytes for each
/// face. Errors: kInvalidArgument for positions that are not float32 x 3 or float64 x 3; kBudget
/// for a patch of more than half of the budget; kCancelled; those of Reader.
DistanceDepths depths_by_distance(const Store& store, const RelativeLength& wanted, int balance,
                                  const JobWatch& watch);

/// The depths for the smallest tolerance for which at most `most` vertices are left, with sides as
/// coarse as faces; result.distance is that of what is drawn. Memory: also 8 bytes for each face
/// and level. Errors: kInvalidArgument for fewer vertices than the base mesh has; those of
/// depths_by_distance().
DistanceDepths depths_by_vertices(const Store& store, std::uint64_t most, int balance,
                                  const JobWatch& watch);

PLAIT_END_NAMESPACE
