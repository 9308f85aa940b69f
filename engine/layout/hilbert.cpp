#include "layout/hilbert.h"

namespace plait::layout {
namespace {

/// Moves bit b to bit 3 b, for each of the low kHilbertBits bits.
std::uint64_t spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffff;
  x = (x | x << 16) & 0x001f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace

std::uint64_t hilbert_key(std::array<std::uint32_t, 3> cell) noexcept {
  for (std::uint32_t& x : cell) x &= (1u << kHilbertBits) - 1;
  // Each octant reflects the finer bits or exchanges their axes. Undo this from the coarsest bit
  // down. The code uses masks and no branches, because a processor cannot predict the bits of a
  // cell.
  for (int level = kHilbertBits - 1; level > 0; --level) {
    const std::uint32_t finer = (1u << level) - 1;
    for (std::uint32_t& x : cell) {
      const std::uint32_t reflected = 0 - (x >> level & 1u);
      cell[0] ^= finer & reflected;
      const std::uint32_t difference = (cell[0] ^ x) & finer & ~reflected;
      cell[0] ^= difference;
      x ^= difference;
    }
  }
  // The remaining bits are the Gray code of the key, distributed over the three axes in turn.
  cell[1] ^= cell[0];
  cell[2] ^= cell[1];
  std::uint32_t parity = cell[2];  // bit b: the parity of bits b and higher of cell[2]
  for (int shift = 1; shift < kHilbertBits; shift *= 2) parity ^= parity >> shift;
  const std::uint32_t flip = parity >> 1;
  return spread(cell[0] ^ flip) << 2 | spread(cell[1] ^ flip) << 1 | spread(cell[2] ^ flip);
}

}  // namespace plait::layout
