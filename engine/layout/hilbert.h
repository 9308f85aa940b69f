// layout/hilbert.h: positions along a three-dimensional Hilbert curve.
#pragma once

#include <array>
#include <cstdint>

namespace plait::layout {

constexpr int kHilbertBits = 21;  ///< an axis: three of them fill a 64-bit key but for one bit

/// The distance along the Hilbert curve of the cell (x, y, z): a bijection between cells and keys,
/// under which neighbouring keys are cells that share a side. Only the low kHilbertBits count.
/// Source: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004).
/// Pinned by tests/engine/layout/hilbert_test.cpp.
std::uint64_t hilbert_key(std::array<std::uint32_t, 3> cell) noexcept;

}  // namespace plait::layout
