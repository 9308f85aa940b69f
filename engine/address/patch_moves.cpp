#include "plait/detail/patch_moves.h"

#include <array>
#include <cstddef>

#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMostSize = std::size_t{1} << kMostListedMoves,
                      kMostMoves = (kMostSize + 1) * (kMostSize + 2) / 2 - 3;
using MovesOfLevel = std::array<PatchMove, kMostMoves>;

/// plait/detail/face_slots.h has the table of rows and columns.
MovesOfLevel list_moves(int level) {
  MovesOfLevel moves{};
  auto next = moves.begin();
  const std::int64_t size = std::int64_t{1} << level;
  for (int born = 1; born <= level; ++born)
    for (int side = 0; side < 3; ++side) {
      const std::int64_t n = slot_side(born);
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; row + column < n; ++column) {
          const FaceIndex at = at_level(from_side(0, {side, born, row, column}), level);
          *next++ = {static_cast<std::uint16_t>(row * n + column),
                     static_cast<std::uint16_t>(at.j * (size + 1) - at.j * (at.j - 1) / 2 + at.i)};
        }
    }
  return moves;
}

}  // namespace

const PatchMove* patch_moves(int level) noexcept {
  static const std::array<MovesOfLevel, kMostListedMoves> all = [] {
    std::array<MovesOfLevel, kMostListedMoves> lists;
    for (int of = 1; of <= kMostListedMoves; ++of)
      lists[static_cast<std::size_t>(of - 1)] = list_moves(of);
    return lists;
  }();
  return all[static_cast<std::size_t>(level - 1)].data();
}

PLAIT_END_NAMESPACE
