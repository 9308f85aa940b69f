#include "layout/hilbert.h"

namespace plait::layout {

std::uint64_t hilbert_key(std::array<std::uint32_t, 3> cell) noexcept {
  for (std::uint32_t& x : cell) x &= (1u << kHilbertBits) - 1;
  // From the coarsest bit down, undo the reflection or the exchange of axes that each octant puts
  // on the finer bits.
  for (std::uint32_t bit = 1u << (kHilbertBits - 1); bit > 1; bit >>= 1) {
    const std::uint32_t finer = bit - 1;
    for (std::uint32_t& x : cell) {
      if ((x & bit) != 0) {
        cell[0] ^= finer;
      } else {
        const std::uint32_t difference = (cell[0] ^ x) & finer;
        cell[0] ^= difference;
        x ^= difference;
      }
    }
  }
  // What is left is the Gray code of the key, its bits dealt to the axes in turn.
  cell[1] ^= cell[0];
  cell[2] ^= cell[1];
  std::uint32_t flip = 0;
  for (std::uint32_t bit = 1u << (kHilbertBits - 1); bit > 1; bit >>= 1)
    if ((cell[2] & bit) != 0) flip ^= bit - 1;
  std::uint64_t key = 0;
  for (int bit = kHilbertBits - 1; bit >= 0; --bit)
    for (const std::uint32_t x : cell) key = (key << 1) | (((x ^ flip) >> bit) & 1u);
  return key;
}

}  // namespace plait::layout
