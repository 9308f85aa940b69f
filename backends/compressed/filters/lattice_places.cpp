#include "compressed/filters/lattice_places.h"

#include <algorithm>
#include <utility>

#include "plait/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

LatticePlaces::LatticePlaces(int refinement, std::size_t record_bytes)
    : refinement_(refinement),
      listed_(refinement > kLargestLattice ? 0 : std::min(refinement - 1, kMostListed)),
      size_(slot_side(refinement)),
      stride_(size_ + 3) {
  std::array<std::array<std::pair<std::size_t, std::size_t>, kMostListed>, 24> ranges{};
  const auto for_each_list = [&](auto visit) {
    for (int coarser = 1; coarser <= listed_; ++coarser) {
      for (const SlotView view : {SlotView::kHalf, SlotView::kWhole})
        visit(SidePlace{false, 0, view}, coarser);
      for (const bool turned : {false, true})
        for (const int turn : {1, 2})
          for (const SlotView view : {SlotView::kOwn, SlotView::kOther, SlotView::kHalf})
            visit(SidePlace{turned, turn, view}, coarser);
    }
  };
  for_each_list([&](const SidePlace& side, int coarser) {
    const std::size_t begin = places_.size();
    visit(side, coarser, [&](std::int64_t to, std::int64_t from) {
      const auto bytes = static_cast<std::int64_t>(record_bytes);
      places_.push_back(
          {static_cast<std::int32_t>(bytes * to), static_cast<std::int32_t>(bytes * from)});
    });
    ranges[index(side)][static_cast<std::size_t>(coarser - 1)] = {begin, places_.size()};
  });
  for_each_list([&](const SidePlace& side, int coarser) {
    const auto [begin, end] = ranges[index(side)][static_cast<std::size_t>(coarser - 1)];
    lists_[index(side)][static_cast<std::size_t>(coarser - 1)] =
        std::span(places_).subspan(begin, end - begin);
  });
}

LatticePlaces::Rows LatticePlaces::rows(const SidePlace& side, int refinement) const noexcept {
  const std::int64_t scale = std::int64_t{1} << (refinement_ - 1 - refinement), both = 2 * scale;
  // On the side of the lattice's edge, p increases with the row and q with the column; on the next
  // side q increases with the row, and on the last side p with the column; the third weight,
  // opposite the edge, changes accordingly.
  Rows rows{scale * stride_ + scale, both * stride_, both, scale * stride_ - scale};
  if (side.turn == 1)
    rows = {(size_ - both) * stride_ + scale, both - both * stride_, -both * stride_, scale};
  else if (side.turn == 2)
    rows = {scale * stride_ + (size_ - both), -both, both * stride_ - both, scale * stride_};
  if (side.turned) {
    rows.first = size_ * stride_ + size_ - rows.first;
    rows.row_step = -rows.row_step;
    rows.column_step = -rows.column_step;
  }
  return rows;
}

PLAIT_END_NAMESPACE
