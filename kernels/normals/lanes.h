// The three numbers of a record at once. In float32 they take four lanes of a vector register, and
// the fourth lane is not used. In float64 they are plain numbers. Each lane has the same IEEE
// operations as the scalar rules, so the bits are equal. Pinned by
// tests/kernels/slot_rows_test.cpp.
#pragma once

#include <cmath>
#include <cstring>

#include "plait/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

using Lanes = float __attribute__((vector_size(16)));

/// REQUIRES: the 4 bytes after the record are readable, as they are in an EdgeGrid.
inline Lanes load(const Vector3<float>* record) {
  Lanes lanes;
  std::memcpy(&lanes, record, sizeof(lanes));
  return lanes;
}
inline Vector3<double> load(const Vector3<double>* record) { return *record; }

/// Reads the record and no byte after it.
inline Lanes load_exactly(const Vector3<float>* record) {
  return Lanes{record->x, record->y, record->z, 0};
}
inline Vector3<double> load_exactly(const Vector3<double>* record) { return *record; }

inline void store(const Lanes& lanes, Vector3<float>* to) {
  std::memcpy(to, &lanes, sizeof(Vector3<float>));
}
inline void store(const Vector3<double>& value, Vector3<double>* to) { *to = value; }

/// plait::cross, with the products in the same order.
inline Lanes cross(const Lanes& a, const Lanes& b) {
  const Lanes a_yzx = __builtin_shufflevector(a, a, 1, 2, 0, 3);
  const Lanes a_zxy = __builtin_shufflevector(a, a, 2, 0, 1, 3);
  const Lanes b_yzx = __builtin_shufflevector(b, b, 1, 2, 0, 3);
  const Lanes b_zxy = __builtin_shufflevector(b, b, 2, 0, 1, 3);
  return a_yzx * b_zxy - a_zxy * b_yzx;
}

PLAIT_END_NAMESPACE
