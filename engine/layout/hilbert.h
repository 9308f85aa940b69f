// layout/hilbert.h: positions along a three-dimensional Hilbert curve.
#pragma once

#include <array>
#include <cstdint>

namespace plait::layout {

constexpr int kHilbertBits = 21;  ///< per axis: a key has 63 bits

/// The distance along the Hilbert curve of the cell (x, y, z): a bijection between cells and keys.
/// The cells of two consecutive keys share a side. Only the low kHilbertBits bits of each
/// coordinate count.
/// Source: J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004).
/// Pinned by tests/engine/layout/face_order_test.cpp.
std::uint64_t hilbert_key(std::array<std::uint32_t, 3> cell) noexcept;

}  // namespace plait::layout
