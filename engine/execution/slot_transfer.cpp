#include "execution/slot_transfer.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstring>

namespace plait {
namespace {

/// Four floats: what every 64-bit machine has in a register. GCC's and Clang's vector extension.
typedef float Quad __attribute__((vector_size(16)));

Quad load(const float* from) {
  Quad v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
void store(const Quad& v, void* to) { std::memcpy(to, &v, sizeof v); }
/// REQUIRES: `to` is aligned to a Quad.
void stream(const Quad& v, float* to) {
#if defined(__SSE2__)
  _mm_stream_ps(to, v);
#else
  store(v, to);
#endif
}

/// Where a lane's next record goes, and from there the next one in its row.
struct Cursor {
  std::byte* to = nullptr;
  std::ptrdiff_t step = 0;
};
using Cursors = std::array<Cursor, kPatchLanes>;

/// One point of a group: [component][lane] numbers to one record per lane.
struct AnyPoint {
  std::size_t components, component_bytes;
  void operator()(const std::byte* from, const Cursors& cursors, std::int64_t column) const {
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      std::byte* to = cursors[lane].to + column * cursors[lane].step;
      for (std::size_t c = 0; c < components; ++c)
        std::memcpy(to + c * component_bytes, from + (c * kPatchLanes + lane) * component_bytes,
                    component_bytes);
    }
  }
};

/// Three floats: a transposition in registers, and one store for each record with a zero behind it.
struct Float3Point {
  void operator()(const std::byte* from, const Cursors& cursors, std::int64_t column) const {
    const float* numbers = reinterpret_cast<const float*>(from);
    const Quad zero{};
    const auto put = [&](const Quad& record, std::size_t lane) {
      store(record, cursors[lane].to + column * cursors[lane].step);
    };
    for (std::size_t half = 0; half < kPatchLanes; half += 4) {
      const Quad x = load(numbers + half), y = load(numbers + kPatchLanes + half),
                 z = load(numbers + 2 * kPatchLanes + half);
      const Quad xy01 = __builtin_shufflevector(x, y, 0, 4, 1, 5),
                 xy23 = __builtin_shufflevector(x, y, 2, 6, 3, 7),
                 z01 = __builtin_shufflevector(z, zero, 0, 4, 1, 5),
                 z23 = __builtin_shufflevector(z, zero, 2, 6, 3, 7);
      put(__builtin_shufflevector(xy01, z01, 0, 1, 4, 5), half);
      put(__builtin_shufflevector(xy01, z01, 2, 3, 6, 7), half + 1);
      put(__builtin_shufflevector(xy23, z23, 0, 1, 4, 5), half + 2);
      put(__builtin_shufflevector(xy23, z23, 2, 3, 6, 7), half + 3);
    }
  }
};

/// One side's slots at `level`. The own face has row + column < n of them, the other face those
/// without the diagonal, seen from the far end.
template <class Point>
void scatter_side(const std::byte* points, std::size_t point_bytes, const PatchLattice& lattice,
                  const BundleShape::Output& output, int levels, int level, int side,
                  const std::array<GroupTargets::Target, kPatchLanes>& targets, std::byte* spare,
                  const Point& point) {
  const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (levels - level);
  const auto stride = static_cast<std::ptrdiff_t>(output.stride);
  const std::size_t offset = output.offsets[static_cast<std::size_t>(level)];
  for (std::int64_t row = 0; row < n; ++row) {
    Cursors cursors;
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane) {
      const GroupTargets::Target& target = targets[lane];
      if (!target.bundle)
        cursors[lane] = {spare, 0};
      else if (target.own)
        cursors[lane] = {
            target.bundle + offset + slot_position(level, target.border, row, 0) * stride, stride};
      else
        cursors[lane] = {target.bundle + offset + ((n - 1 - row) * n + n - 1) * stride, -stride};
    }
    const std::int64_t last = n - 1 - row;
    const auto from = [&](std::int64_t column) {
      const FaceIndex at = from_side(0, {side, level, row, column});
      return points +
             static_cast<std::size_t>(lattice.index(at.i * scale, at.j * scale)) * point_bytes;
    };
    for (std::int64_t column = 0; column < last; ++column) point(from(column), cursors, column);
    for (std::size_t lane = 0; lane < kPatchLanes; ++lane)
      if (!targets[lane].own) cursors[lane] = {spare, 0};
    point(from(last), cursors, last);
  }
}

template <class Point>
void scatter(const void* points, std::size_t point_bytes, const PatchLattice& lattice,
             const BundleShape::Output& output, int levels, const GroupTargets& targets,
             std::byte* spare, const Point& point) {
  for (int level = 1; level <= levels; ++level)
    for (int side = 0; side < 3; ++side)
      scatter_side(static_cast<const std::byte*>(points), point_bytes, lattice, output, levels,
                   level, side, targets.sides[static_cast<std::size_t>(side)], spare, point);
}

/// Four records of three floats and a zero become three whole vectors.
template <class Write>
void close_gaps(const float* from, std::uint64_t records, float* to, Write write) {
  for (std::uint64_t i = 0; i < records; i += 4, from += 16, to += 12) {
    const Quad a = load(from), b = load(from + 4), c = load(from + 8), d = load(from + 12);
    write(__builtin_shufflevector(a, b, 0, 1, 2, 4), to);
    write(__builtin_shufflevector(b, c, 1, 2, 4, 5), to + 4);
    write(__builtin_shufflevector(c, d, 2, 4, 5, 6), to + 8);
  }
}

}  // namespace

void scatter_to_bundles(const void* points, const PatchLattice& lattice, const BundleShape& shape,
                        std::size_t output, const GroupTargets& targets, std::byte* spare) {
  const BundleShape::Output& at = shape.outputs[output];
  const std::size_t point_bytes = at.record_bytes * kPatchLanes;
  if (at.components == 3 && at.component_bytes == 4)
    scatter(points, point_bytes, lattice, at, shape.levels, targets, spare, Float3Point{});
  else
    scatter(points, point_bytes, lattice, at, shape.levels, targets, spare,
            AnyPoint{at.components, at.component_bytes});
}

void copy_to_slot(const BundleShape::Output& shape, const std::byte* bundle, std::uint64_t records,
                  bool streaming, std::byte* slot) {
  if (shape.stride == shape.record_bytes) {
    std::memcpy(slot, bundle, records * shape.record_bytes);
    return;
  }
  const std::uint64_t whole = records / 4 * 4;
  const float* from = reinterpret_cast<const float*>(bundle);
  float* to = reinterpret_cast<float*>(slot);
  if (streaming && reinterpret_cast<std::uintptr_t>(slot) % sizeof(Quad) == 0)
    close_gaps(from, whole, to, [](const Quad& v, float* at) { stream(v, at); });
  else
    close_gaps(from, whole, to, [](const Quad& v, float* at) { store(v, at); });
  for (std::uint64_t record = whole; record < records; ++record)
    std::memcpy(slot + record * shape.record_bytes, bundle + record * shape.stride,
                shape.record_bytes);
}

void finish_streaming() {
#if defined(__SSE2__)
  _mm_sfence();
#endif
}

}  // namespace plait
