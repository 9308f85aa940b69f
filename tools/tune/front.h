// tools/tune/front.h: the Pareto front, and the speed at which one choice overtakes another.
// Pinned by tests/tools/tune/front_test.cpp.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace plait::tune {

/// Costs of one choice; less is better in each.
using Costs = std::vector<double>;

/// The indices of the choices that no other one beats. A choice is beaten by one that costs at most
/// as much in everything, and less in something. Of equal choices the first stays. Ascending by the
/// first cost. REQUIRES: all have the same number of costs.
std::vector<std::size_t> pareto_front(std::span<const Costs> choices);

/// Seconds as a function of the speed of a disk, in bytes a second.
using SecondsAtSpeed = std::function<double(double speed)>;

/// The slowest speeds of interest, and the fastest.
inline constexpr double kSlowestDisk = 1e6, kFastestDisk = 1e12;

/// The speed from which on `other` takes less time than `first`. Nothing unless `first` takes less
/// at kSlowestDisk, and `other` at kFastestDisk. Correct to one part in 10,000.
std::optional<double> break_even(const SecondsAtSpeed& first, const SecondsAtSpeed& other);

}  // namespace plait::tune
