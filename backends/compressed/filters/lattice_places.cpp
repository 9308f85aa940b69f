#include "compressed/filters/lattice_places.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

LatticePlaces::LatticePlaces(int refinement, std::size_t record_bytes)
    : grid_(refinement - 1),
      listed_(refinement > kLargestLattice ? 0 : std::min(refinement - 1, kMostListed)) {
  std::array<std::array<std::pair<std::size_t, std::size_t>, kMostListed>, 24> ranges{};
  const auto for_each_list = [&](auto visit) {
    for (int coarser = 1; coarser <= listed_; ++coarser) {
      for (const SlotView view : {SlotView::kHalf, SlotView::kWhole})
        visit(GridSide{false, 0, view}, coarser);
      // Of an edge whose grid begins with its other face.
      visit(GridSide{false, 0, SlotView::kOther}, coarser);
      visit(GridSide{true, 0, SlotView::kOwn}, coarser);
      for (const bool turned : {false, true})
        for (const int turn : {1, 2})
          for (const SlotView view : {SlotView::kOwn, SlotView::kOther, SlotView::kHalf})
            visit(GridSide{turned, turn, view}, coarser);
    }
  };
  for_each_list([&](const GridSide& side, int coarser) {
    const std::size_t begin = places_.size();
    for_each_in_grid(grid_, side, coarser, [&](std::int64_t to, std::int64_t from) {
      const auto bytes = static_cast<std::int64_t>(record_bytes);
      places_.push_back(
          {static_cast<std::int32_t>(bytes * to), static_cast<std::int32_t>(bytes * from)});
    });
    ranges[index(side)][static_cast<std::size_t>(coarser - 1)] = {begin, places_.size()};
  });
  for_each_list([&](const GridSide& side, int coarser) {
    const auto [begin, end] = ranges[index(side)][static_cast<std::size_t>(coarser - 1)];
    lists_[index(side)][static_cast<std::size_t>(coarser - 1)] =
        std::span(places_).subspan(begin, end - begin);
  });
}

PLAIT_END_NAMESPACE
