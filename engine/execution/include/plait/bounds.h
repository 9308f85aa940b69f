// plait/bounds.h: where patches are, so that a Reader (plait/reader.h) finds those in a box or
// along a ray.
//
// The bounds of a patch are the smallest box that contains all of its vertices, at all levels that
// the attribute has. They also contain the triangles of the patch at each of these levels, but not
// always its limit surface. Coordinates of float64 attributes are rounded outwards to float32. A
// coordinate that is not a number does not count.
#pragma once

#include <cstdint>
#include <string_view>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// An axis-aligned box with its faces. Sides may be infinite. The box is empty if a component of
/// `low` is larger than that of `high`.
struct Box {
  Vector3<double> low, high;
};

/// A face whose bounds a ray meets.
struct FaceOnRay {
  FaceId face;
  /// How far from its origin the ray enters the bounds, in lengths of its direction. 0 if the
  /// origin is inside.
  double distance;
  friend bool operator==(const FaceOnRay&, const FaceOnRay&) = default;
};

/// Computes the bounds of all patches, and writes them to a file of the store, which replaces an
/// earlier one. Readers of this version then need not compute them. A commit that changes the
/// attribute makes the file stale: readers recognise that and compute the bounds themselves. Reads
/// each level of the attribute once, and takes 24 bytes of memory for each face. Waits until the
/// file is on the disk. `progress` counts bytes of levels that are read; a call that it cancels
/// changes nothing. REQUIRES: no other thread writes
/// to the store. Errors: kNotFound; kInvalidArgument unless the attribute is float32 x 3 or float64
/// x 3; kNotSupported for a store in memory; kBadState if the attribute has changes that are not
/// committed; kBusy if `store` is open for reading and another one writes it; kCancelled;
/// kIo, kNoSpace; those of Session::pin.
void write_bounds(const Store& store, std::string_view attribute = "position",
                  const ProgressCallback& progress = {});

PLAIT_END_NAMESPACE
