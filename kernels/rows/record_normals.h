// The arguments of the function that computes normals of a run of vertices from records.
#pragma once

#include <cstdint>

#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The vertices have six neighbours each, in opposite pairs. Every pointer leads to the neighbour
/// of the first vertex, and those of the next vertices follow. REQUIRES: after the `count` records
/// of each, kPatchLanes more are readable.
template <class Real>
struct RecordNormals {
  const Vector3<Real>* pairs[3][2];
  std::int64_t count;
  Vector3<float>* to;
};

/// Uses the best instruction set of the processor (see rows/dispatched_rows.h).
template <class Real>
using RecordNormalsRow = void (*)(const RecordNormals<Real>&);
template <class Real>
RecordNormalsRow<Real> record_normals_row();

PLAIT_END_NAMESPACE
