#include "distance/far_places.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::vector<FarPlace> far_places(std::vector<FarSample> far, std::size_t count) {
  constexpr double kReach = 1.25;  // of the distance
  std::vector<FarPlace> places;
  while (!far.empty() && places.size() < kMostFarPlaces) {
    const FarSample farthest = *std::ranges::max_element(far, {}, &FarSample::distance);
    const double reach = kReach * farthest.distance;
    const std::size_t gone = std::erase_if(far, [&](const FarSample& sample) {
      return squared_length(sample.at - farthest.at) <= reach * reach;
    });
    places.push_back(
        {farthest.at, farthest.distance, static_cast<double>(gone) / static_cast<double>(count)});
  }
  return places;
}

PLAIT_END_NAMESPACE
