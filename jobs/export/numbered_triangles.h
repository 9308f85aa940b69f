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

/// Triangles of the longest row of a patch.
inline std::size_t most_triangles_of_row(const PatchSelection& patches) {
  return (std::size_t{2} << patches.refinements()) - 1;
}

/// Calls visit(a, b, c) for every triangle, patch by patch, with the orientation of the base faces.
/// After each row of a patch it calls proceed(triangles so far).
template <class Visit, class Proceed>
void for_each_numbered_triangle(const PatchSelection& patches, Visit visit, Proceed proceed) {
  const int level = patches.refinements();
  const std::int64_t size = std::int64_t{1} << level;
  std::vector<std::uint64_t> lower(static_cast<std::size_t>(size) + 1), upper = lower;
  const auto fetch = [&](std::vector<std::uint64_t>& row, FaceId face, std::int64_t j) {
    for (std::int64_t i = 0; i <= size - j; ++i)
      row[static_cast<std::size_t>(i)] = patches.number({face, level, i, j});
  };
  std::uint64_t done = 0;
  for (const FaceId face : patches.faces()) {
    fetch(lower, face, 0);
    for (std::int64_t j = 0; j < size; ++j) {
      fetch(upper, face, j + 1);
      const auto count = static_cast<std::size_t>(size - j);
      for (std::size_t i = 0; i < count; ++i) {
        visit(lower[i], lower[i + 1], upper[i]);
        if (i + 1 < count) visit(lower[i + 1], upper[i + 1], upper[i]);
      }
      done += 2 * count - 1;
      proceed(done);
      lower.swap(upper);
    }
  }
}

PLAIT_END_NAMESPACE
