// export/numbered_triangles.h: the triangles of a level as vertex numbers. Only two rows of one
// face are in memory.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/extend/vertex_numbering.h"

namespace plait {

/// 4^level for every base face; `level` counts from the base mesh.
inline std::uint64_t triangle_count(const BaseMesh& base, int level) {
  return base.face_count() << (2 * level);
}

/// Calls visit(a, b, c) for every triangle, face by face in layout order, with the orientation of
/// the base faces. After each row of a face it calls proceed(triangles so far).
/// REQUIRES: `numbering` is that of `base` and includes `level`, counted from the base mesh.
template <class Visit, class Proceed>
void for_each_numbered_triangle(const BaseMesh& base, const VertexNumbering& numbering, int level,
                                Visit visit, Proceed proceed) {
  const std::int64_t size = std::int64_t{1} << level;
  std::vector<std::uint64_t> lower(static_cast<std::size_t>(size) + 1), upper = lower;
  const auto fetch = [&](std::vector<std::uint64_t>& row, FaceId face, std::int64_t j) {
    for (std::int64_t i = 0; i <= size - j; ++i)
      row[static_cast<std::size_t>(i)] = numbering.number({face, level, i, j});
  };
  std::uint64_t done = 0;
  for (FaceId face = 0; face < base.face_count(); ++face) {
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

}  // namespace plait
