// export/numbered_triangles.h: the triangles of patches as vertex numbers. Only two rows of one
// patch are in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "export/patch_selection.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Triangles of the longest row of a patch, at most. A row on a side with more vertices than the
/// patch itself has there is longer than others.
inline std::size_t most_triangles_of_row(const PatchSelection& patches) {
  return std::size_t{4} << patches.refinements();
}

/// Calls visit(face, a, b, c) for every triangle, patch by patch, with the orientation of the base
/// faces. After each row of a patch it calls proceed(triangles so far).
template <class Visit, class Proceed>
void for_each_numbered_triangle(const PatchSelection& patches, Visit visit, Proceed proceed) {
  std::vector<std::uint64_t> lower((std::size_t{1} << patches.refinements()) + 1), upper = lower;
  std::uint64_t done = 0;
  for (const FaceId face : patches.faces()) {
    const DrawnDepths drawn = patches.drawn(face);
    const int level = drawn.face;
    const std::int64_t size = std::int64_t{1} << level;
    const auto fetch = [&](std::vector<std::uint64_t>& row, std::int64_t j) {
      for (std::int64_t i = 0; i <= size - j; ++i)
        row[static_cast<std::size_t>(i)] = patches.number({face, level, i, j});
    };
    if (!drawn.is_plain()) {
      const auto number = [&](FacePoint at) {
        return patches.number({face, drawn.grid(), at.i, at.j});
      };
      for_each_drawn_triangle(
          drawn,
          [&](FacePoint a, FacePoint b, FacePoint c) {
            visit(face, number(a), number(b), number(c));
            ++done;
          },
          [&] { proceed(done); });
      continue;
    }
    fetch(lower, 0);
    for (std::int64_t j = 0; j < size; ++j) {
      fetch(upper, j + 1);
      const auto count = static_cast<std::size_t>(size - j);
      for (std::size_t i = 0; i < count; ++i) {
        visit(face, lower[i], lower[i + 1], upper[i]);
        if (i + 1 < count) visit(face, lower[i + 1], upper[i + 1], upper[i]);
      }
      done += 2 * count - 1;
      proceed(done);
      lower.swap(upper);
    }
  }
}

PLAIT_END_NAMESPACE
