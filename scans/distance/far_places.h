// distance/far_places.h: where on a surface the samples are that are far from another one.
#pragma once

#include <cstddef>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

/// Far samples that are near each other.
struct FarPlace {
  Point at{};           ///< the sample that is farthest
  double distance = 0;  ///< its distance
  double share = 0;     ///< of all samples, how many are here
};

PLAIT_END_NAMESPACE
PLAIT_BEGIN_PRIVATE_NAMESPACE

struct FarSample {
  Point at{};
  double distance = 0;
};

/// The most places that far_places() gives.
constexpr std::size_t kMostFarPlaces = 3;

/// The farthest sample and those not farther from it than the tip of a missing limb is from its
/// root, which is its own distance and a quarter; then the farthest of the others, and so on.
/// `count` is the number of all samples. Pinned by tests/scans/distances_test.cpp.
std::vector<FarPlace> far_places(std::vector<FarSample> far, std::size_t count);

PLAIT_END_NAMESPACE
