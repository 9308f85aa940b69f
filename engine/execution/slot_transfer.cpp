#include "execution/slot_transfer.h"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cstring>

namespace plait {
namespace {

/// Lanes whose records are put together in registers.
constexpr std::size_t kQuadLanes = 4;

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

/// Four lanes' ways through their slots: in the slot's frame for the own face, from the far end for
/// the other one.
struct QuadCursor {
  std::array<std::byte*, kQuadLanes> row;       ///< first record of the row
  std::array<std::ptrdiff_t, kQuadLanes> step;  ///< to the next record
  std::array<std::ptrdiff_t, kQuadLanes> row_step, row_step_change;
  std::array<bool, kQuadLanes> own;

  QuadCursor(const GroupTargets::Target* targets, std::size_t offset, std::ptrdiff_t stride,
             std::int64_t n, std::byte* spare) {
    for (std::size_t lane = 0; lane < kQuadLanes; ++lane) {
      const GroupTargets::Target& target = targets[lane];
      const std::ptrdiff_t direction = !target.bundle ? 0 : target.own ? stride : -stride;
      step[lane] = direction;
      row_step[lane] = n * direction;
      row_step_change[lane] = target.border ? -direction : 0;
      own[lane] = target.own;
      row[lane] = !target.bundle ? spare
                                 : target.bundle + offset + (target.own ? 0 : (n * n - 1) * stride);
    }
  }
  void next_row() {
    for (std::size_t lane = 0; lane < kQuadLanes; ++lane) {
      row[lane] += row_step[lane];
      row_step[lane] += row_step_change[lane];
    }
  }
};

/// [component][lane] numbers to one record per lane.
struct AnyRecord {
  std::size_t components, component_bytes;
  void put(const std::byte* from, std::byte* to, std::size_t lane) const {
    for (std::size_t c = 0; c < components; ++c)
      std::memcpy(to + c * component_bytes, from + (c * kPatchLanes + lane) * component_bytes,
                  component_bytes);
  }
  void operator()(const std::byte* from, SlotScatter::Path path, const QuadCursor& to,
                  std::byte*) const {
    std::ptrdiff_t step = path.step;
    for (std::int64_t column = 0; column < path.inner; ++column) {
      for (std::size_t lane = 0; lane < kQuadLanes; ++lane)
        put(from, to.row[lane] + column * to.step[lane], lane);
      from += step;
      step += path.step_change;
    }
    for (std::size_t lane = 0; lane < kQuadLanes; ++lane)
      if (to.own[lane]) put(from, to.row[lane] + path.inner * to.step[lane], lane);
  }
};

/// Three floats: a transposition in registers, and one store for each record with a zero behind it.
struct Float3Record {
  static void put(const std::byte* from, std::byte* to0, std::byte* to1, std::byte* to2,
                  std::byte* to3) {
    const float* numbers = reinterpret_cast<const float*>(from);
    const Quad zero{}, x = load(numbers), y = load(numbers + kPatchLanes),
                       z = load(numbers + 2 * kPatchLanes);
    const Quad xy01 = __builtin_shufflevector(x, y, 0, 4, 1, 5),
               xy23 = __builtin_shufflevector(x, y, 2, 6, 3, 7),
               z01 = __builtin_shufflevector(z, zero, 0, 4, 1, 5),
               z23 = __builtin_shufflevector(z, zero, 2, 6, 3, 7);
    store(__builtin_shufflevector(xy01, z01, 0, 1, 4, 5), to0);
    store(__builtin_shufflevector(xy01, z01, 2, 3, 6, 7), to1);
    store(__builtin_shufflevector(xy23, z23, 0, 1, 4, 5), to2);
    store(__builtin_shufflevector(xy23, z23, 2, 3, 6, 7), to3);
  }
  void operator()(const std::byte* from, SlotScatter::Path path, const QuadCursor& to,
                  std::byte* spare) const {
    auto [to0, to1, to2, to3] = to.row;
    const auto [step0, step1, step2, step3] = to.step;
    std::ptrdiff_t step = path.step;
    const std::ptrdiff_t change = path.step_change;
    for (std::int64_t column = path.inner; column > 0; --column) {
      put(from, to0, to1, to2, to3);
      from += step;
      step += change;
      to0 += step0, to1 += step1, to2 += step2, to3 += step3;
    }
    put(from, to.own[0] ? to0 : spare, to.own[1] ? to1 : spare, to.own[2] ? to2 : spare,
        to.own[3] ? to3 : spare);
  }
};

template <class Record>
void scatter(const void* points, std::span<const SlotScatter::Path> paths,
             const BundleShape::Output& output, int levels, const GroupTargets& targets,
             std::byte* spare, const Record& record) {
  const auto stride = static_cast<std::ptrdiff_t>(output.stride);
  const SlotScatter::Path* path = paths.data();
  for (int level = 1; level <= levels; ++level) {
    const std::int64_t n = slot_side(level);
    for (std::size_t side = 0; side < 3; ++side, path += n)
      for (std::size_t lane = 0; lane < kPatchLanes; lane += kQuadLanes) {
        const std::byte* from =
            static_cast<const std::byte*>(points) + lane * output.component_bytes;
        QuadCursor to(targets.sides[side].data() + lane,
                      output.offsets[static_cast<std::size_t>(level)], stride, n, spare);
        for (std::int64_t row = 0; row < n; ++row) {
          record(from + path[row].first, path[row], to, spare);
          to.next_row();
        }
      }
  }
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

SlotScatter::SlotScatter(const PatchLattice& lattice, const BundleShape& shape) : shape_(shape) {
  for (const BundleShape::Output& output : shape.outputs) {
    const auto point_bytes = static_cast<std::ptrdiff_t>(output.record_bytes * kPatchLanes);
    std::vector<Path>& paths = paths_.emplace_back();
    for (int level = 1; level <= shape.levels; ++level) {
      const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (shape.levels - level);
      for (int side = 0; side < 3; ++side)
        for (std::int64_t row = 0; row < n; ++row) {
          const auto offset = [&](std::int64_t column) {
            const FaceIndex at = from_side(0, {side, level, row, std::min(column, n - 1 - row)});
            return lattice.index(at.i * scale, at.j * scale) * point_bytes;
          };
          const std::ptrdiff_t step = offset(1) - offset(0);
          const std::ptrdiff_t change = row + 2 < n ? offset(2) - offset(1) - step : 0;
          paths.push_back({offset(0), step, change, n - 1 - row});
        }
    }
  }
}

void SlotScatter::operator()(std::size_t output, const void* points, const GroupTargets& targets,
                             std::byte* spare) const {
  const BundleShape::Output& at = shape_.outputs[output];
  if (at.components == 3 && at.component_bytes == 4)
    scatter(points, paths_[output], at, shape_.levels, targets, spare, Float3Record{});
  else
    scatter(points, paths_[output], at, shape_.levels, targets, spare,
            AnyRecord{at.components, at.component_bytes});
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
