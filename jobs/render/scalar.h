// render/scalar.h: an attribute of one number for each vertex, of any type, as shares of its range.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The least and the largest number of the attribute's vertices up to `level`, without those that
/// are not finite; 0 and 1 if there are none. Reads all of them. Errors: kNotFound;
/// kInvalidArgument if a record is not one number, or the attribute ends at a coarser level.
struct ScalarRange {
  double low = 0, high = 1;
};
ScalarRange scalar_range(Store& store, const std::string& attribute, int level);

/// The numbers of one patch after another.
class ScalarPatches {
 public:
  ScalarPatches() = default;
  ScalarPatches(const ScalarPatches&) = delete;
  ScalarPatches& operator=(const ScalarPatches&) = delete;
  virtual ~ScalarPatches() = default;
  virtual void enter(FaceId face) = 0;
  virtual double at(std::int64_t i, std::int64_t j) const = 0;
};
/// REQUIRES: an attribute that scalar_range() takes. It pins blocks of at most `share_bytes`.
std::unique_ptr<ScalarPatches> open_scalar(Store& store, const std::string& attribute, int level,
                                           std::uint64_t share_bytes);

PLAIT_END_NAMESPACE
