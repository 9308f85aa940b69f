#include "tune/front.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace plait::tune {
namespace {

/// Whether `a` costs at most as much as `b` in everything.
bool costs_no_more(const Costs& a, const Costs& b) {
  return std::ranges::equal(a, b, [](double x, double y) { return x <= y; });
}

}  // namespace

std::vector<std::size_t> pareto_front(std::span<const Costs> choices) {
  std::vector<std::size_t> order(choices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  // What beats a choice comes before it in this order.
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return std::ranges::lexicographical_compare(choices[a], choices[b]);
  });
  std::vector<std::size_t> front;
  for (const std::size_t at : order)
    if (std::ranges::none_of(
            front, [&](std::size_t kept) { return costs_no_more(choices[kept], choices[at]); }))
      front.push_back(at);
  return front;
}

std::optional<double> break_even(const SecondsAtSpeed& first, const SecondsAtSpeed& other) {
  const auto other_is_faster = [&](double speed) { return other(speed) < first(speed); };
  if (!(first(kSlowestDisk) < other(kSlowestDisk)) || !other_is_faster(kFastestDisk))
    return std::nullopt;
  double slow = kSlowestDisk, fast = kFastestDisk;
  while (fast / slow > 1.0001) {
    const double middle = std::sqrt(slow * fast);
    (other_is_faster(middle) ? fast : slow) = middle;
  }
  return std::sqrt(slow * fast);
}

}  // namespace plait::tune
