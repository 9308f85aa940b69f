#include "layout/hilbert.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <map>
#include <set>

using plait::layout::hilbert_key;
using plait::layout::kHilbertBits;

namespace {

using Cell = std::array<std::uint32_t, 3>;

/// The cells of a cube with `side` cells per axis and its lowest cell at `corner`, by key.
std::map<std::uint64_t, Cell> cube_by_key(std::uint32_t corner, std::uint32_t side) {
  std::map<std::uint64_t, Cell> cells;
  for (std::uint32_t x = corner; x < corner + side; ++x)
    for (std::uint32_t y = corner; y < corner + side; ++y)
      for (std::uint32_t z = corner; z < corner + side; ++z)
        cells[hilbert_key({x, y, z})] = {x, y, z};
  return cells;
}

int distance(const Cell& a, const Cell& b) {
  int sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    sum += std::abs(static_cast<int>(a[axis]) - static_cast<int>(b[axis]));
  return sum;
}

}  // namespace

TEST_CASE("HilbertKey_AlignedCubes_AreFilledByNeighbourAfterNeighbour") {
  constexpr std::uint32_t kSide = 16;
  for (const std::uint32_t corner : {0u, 16u, 1u << 20, (1u << kHilbertBits) - kSide}) {
    const std::map<std::uint64_t, Cell> cells = cube_by_key(corner, kSide);
    REQUIRE(cells.size() == kSide * kSide * kSide);
    CHECK(cells.rbegin()->first - cells.begin()->first == cells.size() - 1);
    int breaks = 0;
    for (auto cell = cells.begin(), next = std::next(cell); next != cells.end(); ++cell, ++next)
      breaks += distance(cell->second, next->second) == 1 ? 0 : 1;
    CHECK(breaks == 0);
  }
}

TEST_CASE("HilbertKey_OriginAndRange_AreZeroAndBelow63Bits") {
  CHECK(hilbert_key({0, 0, 0}) == 0);
  constexpr std::uint32_t kLast = (1u << kHilbertBits) - 1;
  for (const Cell cell :
       {Cell{kLast, 0, 0}, Cell{0, kLast, 0}, Cell{0, 0, kLast}, Cell{kLast, kLast, kLast}})
    CHECK(hilbert_key(cell) < std::uint64_t{1} << (3 * kHilbertBits));
}
