// plait/detail/face_slots.h: the addresses of the records of one base face, from the slots of its
// edges.
//
// Let s be the number of common trailing zero bits of i and j. Then l = k - s is the refinement
// that creates the vertex, and k1 = i >> s, k2 = j >> s are its coordinates there. The low bits of
// k1 and k2 tell the side (see plait/extend/edge_index.h). With a = k1 >> 1, b = k2 >> 1 and n =
// 2^(l-1), the slot's coordinates are linear in (a, b) on every side:
//
//   bits k1 k2   side        row           column
//        1  1    0 (bc)      a             b
//        0  1    1 (ca)      b             n-1 - a-b
//        1  0    2 (ab)      n-1 - a-b     a
//
// Seen from the edge's other face, row and column count backwards. So an origin and two steps give
// the address of any record of a whole slot. A half slot is stored in the frame of its one face. It
// is a triangle, whose rows become shorter, so row (row - 1) / 2 records are subtracted from the
// address. Corners reduce to level 0 with a = b = 0, and their low bits tell which corner it is. So
// corners need no branch.
//
// Pinned by tests/engine/execution/patch_test.cpp and reader_test.cpp.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "plait/detail/namespace.h"
#include "plait/detail/patch_moves.h"
#include "plait/detail/slot_shapes.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_NAMESPACE

/// Levels count how often the base mesh is refined. The caller must keep the slots at their
/// addresses while it uses this object. find() may be called from several threads at once.
class FaceSlots {
 public:
  /// The address of a point of the face. REQUIRES: the point is in the face, and all slots of the
  /// levels up to `level` were set.
  [[gnu::always_inline]] std::byte* find(int level, std::int64_t i, std::int64_t j) const {
    const int shift =
        std::countr_zero(static_cast<std::uint64_t>(i | j | std::int64_t{1} << level));
    const std::int64_t k1 = i >> shift, k2 = j >> shift;
    const auto bits = static_cast<std::size_t>((k1 & 1) | (k2 & 1) << 1);
    const Steps& steps = steps_[static_cast<std::size_t>(level - shift)][bits];
    const std::int64_t a = k1 >> 1, b = k2 >> 1;
    std::byte* const address = steps.origin + (a * steps.a_step + b * steps.b_step);
    if (steps.triangle_step == 0) [[likely]]
      return address;
    const std::int64_t n = slot_side(level - shift);
    const std::int64_t row = bits == 3 ? a : bits == 2 ? b : n - 1 - a - b;
    return address - row * (row - 1) / 2 * steps.triangle_step;
  }

  /// Copies the records of the whole face at `level` to `to`, in row order (plait/reader.h): row by
  /// row of each slot, so that the processor reads them one after another. REQUIRES: as find().
  template <class Record>
  void copy_to(int level, Record* to) const {
    const std::int64_t size = std::int64_t{1} << level;
    for (std::size_t corner = 0; corner < 3; ++corner)
      std::memcpy(to + place(size, corner == 1 ? size : 0, corner == 2 ? size : 0),
                  steps_[0][corner].origin, sizeof(Record));
    prefetch<Record>(1, level);
    if (level >= 1 && level <= kMostListedMoves) return copy_listed(level, to);
    for (int born = 1; born <= level; ++born) {
      copy_slot<3>(born, level, to);
      copy_slot<2>(born, level, to);
      copy_slot<1>(born, level, to);
    }
  }

  /// The inverse: copies records of the whole face at `level`, in row order, to the slots of the
  /// vertices that refinements `first` to `level` create. `with_edge[side]`: those on this side
  /// too. Corners stay. REQUIRES: as find().
  template <class Record>
  void copy_from(int first, int level, const std::array<bool, 3>& with_edge,
                 const Record* from) const {
    prefetch<Record>(first, level);
    for (int born = first; born <= level; ++born) {
      fill_slot<3>(born, level, with_edge[0], from);
      fill_slot<2>(born, level, with_edge[1], from);
      fill_slot<1>(born, level, with_edge[2], from);
    }
  }

  /// Sets the slot of side `side` at `level`. `own`: the face is the own face of the edge.
  void set(int side, int level, const LocatedSlot& slot, bool own, std::size_t record_bytes) {
    const bool half = slot.shape == SlotShape::kHalf, forwards = own || half;
    const auto bytes = static_cast<std::int64_t>(record_bytes);
    const std::int64_t n = slot_side(level), record = forwards ? bytes : -bytes;
    std::byte* const first = slot.bytes.data() + (forwards ? 0 : (n * n - 1) * bytes);
    const std::int64_t triangle_step = half ? bytes : 0;
    auto& steps = steps_[static_cast<std::size_t>(level)];
    switch (side) {
      case 0:
        steps[3] = {first, n * record, record, triangle_step};
        break;
      case 1:
        steps[2] = {first + (n - 1) * record, -record, (n - 1) * record, triangle_step};
        break;
      default:
        steps[1] = {first + (n - 1) * n * record, (1 - n) * record, -n * record, triangle_step};
    }
  }
  /// Sets the corners: corner x is corner x + turn of `face` (modulo 3). `base` is the address of
  /// the records of the base vertices.
  void set_corners(const Topology& mesh, FaceId face, int turn, std::byte* base,
                   std::size_t record_bytes) {
    for (int corner = 0; corner < 3; ++corner) {
      const VertexId vertex = mesh.faces[face][static_cast<std::size_t>((corner + turn) % 3)];
      steps_[0][static_cast<std::size_t>(corner)] = {base + vertex * record_bytes};
    }
  }

 private:
  /// The origin and the steps that turn the coordinates a, b of a point into an address.
  struct Steps {
    std::byte* origin = nullptr;
    std::int64_t a_step = 0, b_step = 0;  ///< bytes
    std::int64_t triangle_step = 0;       ///< bytes of a record in a half slot, else 0
  };

  /// The place of (i, j) in row order.
  static std::int64_t place(std::int64_t size, std::int64_t i, std::int64_t j) {
    return j * (size + 1) - j * (j - 1) / 2 + i;
  }
  /// Bytes from one record of a slot's row to the next one in this face.
  template <int kBits>
  static std::int64_t step_in_row(const Steps& steps) {
    return kBits == 3 ? steps.b_step : kBits == 2 ? steps.a_step : steps.a_step - steps.b_step;
  }
  /// a, b of the first record of a slot's row: the table above, read backwards.
  template <int kBits>
  static std::array<std::int64_t, 2> begin_of_row(std::int64_t n, std::int64_t row) {
    return {kBits == 3 ? row : 0, kBits == 3 ? 0 : kBits == 2 ? row : n - 1 - row};
  }
  /// The address of that record.
  template <int kBits>
  static std::byte* row_of_slot(const Steps& steps, std::int64_t n, std::int64_t row) {
    const auto [a, b] = begin_of_row<kBits>(n, row);
    return steps.origin - row * (row - 1) / 2 * steps.triangle_step +
           (a * steps.a_step + b * steps.b_step);
  }
  /// The rows are short and lie apart, so the processor does not prefetch them by itself.
  template <class Record>
  [[gnu::always_inline]] void prefetch(int first, int level) const {
    for (int born = first; born <= level; ++born) {
      prefetch_slot<3, Record>(born);
      prefetch_slot<2, Record>(born);
      prefetch_slot<1, Record>(born);
    }
  }
  /// Inlined, because GCC drops the call of a function that does nothing but prefetch.
  template <int kBits, class Record>
  [[gnu::always_inline]] void prefetch_slot(int born) const {
    constexpr std::int64_t kCacheLine = 64;
    const Steps steps = steps_[static_cast<std::size_t>(born)][kBits];
    const std::int64_t n = slot_side(born), step = step_in_row<kBits>(steps);
    for (std::int64_t row = 0; row < n; ++row) {
      const std::byte* const start = row_of_slot<kBits>(steps, n, row);
      const std::byte* const end = start + (n - 1 - row) * step;
      const std::byte* const first = step < 0 ? end : start;
      const std::int64_t bytes =
          (step < 0 ? start - end : end - start) + static_cast<std::int64_t>(sizeof(Record));
      for (std::int64_t at = 0; at < bytes; at += kCacheLine) __builtin_prefetch(first + at);
      __builtin_prefetch(first + bytes - 1);
    }
  }
  /// Copies the whole face but its corners, by a list of moves.
  template <class Record>
  [[gnu::noinline]] void copy_listed(int level, Record* to) const {
    const PatchMove* next = patch_moves(level);
    const auto copy_half = [&](const std::byte* first, std::int64_t step, const Steps& steps,
                               std::int64_t n) {
      const PatchMove* const end = next + n * (n + 1) / 2;
      if (steps.triangle_step == 0) [[likely]]
        for (; next != end; ++next)
          std::memcpy(to + next->place, first + next->record * step, sizeof(Record));
      else  // the records of a half slot are adjacent
        for (; next != end; ++next, first += step)
          std::memcpy(to + next->place, first, sizeof(Record));
    };
    for (int born = 1; born <= level; ++born) {
      const std::int64_t n = slot_side(born);
      const auto& [corner, ab, ca, bc] = steps_[static_cast<std::size_t>(born)];
      copy_half(row_of_slot<3>(bc, n, 0), step_in_row<3>(bc), bc, n);
      copy_half(ca.origin + (n - 1) * ca.a_step, -ca.a_step, ca, n);
      copy_half(row_of_slot<1>(ab, n, 0), step_in_row<1>(ab), ab, n);
    }
  }
  /// Copies the face's part of the slot that the refinement `born` creates on the side with these
  /// low bits of k1 and k2.
  template <int kBits, class Record>
  [[gnu::noinline]] void copy_slot(int born, int level, Record* to) const {
    for_each_in_slot<kBits>(born, level, true, [&](const std::byte* record, std::int64_t at) {
      std::memcpy(to + at, record, sizeof(Record));
    });
  }
  template <int kBits, class Record>
  [[gnu::noinline]] void fill_slot(int born, int level, bool with_edge, const Record* from) const {
    for_each_in_slot<kBits>(born, level, with_edge, [&](std::byte* record, std::int64_t at) {
      std::memcpy(record, from + at, sizeof(Record));
    });
  }
  /// Calls visit(record, place in row order) for that part of the slot. One record of each row is
  /// on the edge: on side 1 the first one, on the others the last one.
  template <int kBits, class Visit>
  [[gnu::always_inline]] void for_each_in_slot(int born, int level, bool with_edge,
                                               Visit visit) const {
    const Steps steps = steps_[static_cast<std::size_t>(born)][kBits];
    const std::int64_t size = std::int64_t{1} << level, n = slot_side(born);
    const int shift = level - born;
    // Along a row of the slot, i and j change by d or not at all. So the place in row order changes
    // by a step that itself changes by -d^2, or by d.
    const std::int64_t d = std::int64_t{2} << shift;
    const std::int64_t from_step = step_in_row<kBits>(steps);
    for (std::int64_t row = 0; row < n; ++row) {
      const auto [a, b] = begin_of_row<kBits>(n, row);
      const std::int64_t i = (2 * a + (kBits & 1)) << shift, j = (2 * b + (kBits >> 1)) << shift;
      std::byte* const start = row_of_slot<kBits>(steps, n, row);
      std::int64_t step = kBits == 3   ? d * (size + 1) - d * (2 * j + d - 1) / 2
                          : kBits == 2 ? d
                                       : d * (2 * j - d - 1) / 2 - d * size;
      std::int64_t at = place(size, i, j), from = 0, left = n - row;
      if (!with_edge) {
        --left;
        if constexpr (kBits == 2) {
          from += from_step;
          at += step;
        }
      }
      for (; left > 0; --left) {
        visit(start + from, at);
        from += from_step;
        at += step;
        if constexpr (kBits != 2) step -= d * d;
      }
    }
  }

  std::array<std::array<Steps, 4>, kMaxLevel + 1> steps_{};  ///< [level][low bits of k1, k2]
};

PLAIT_END_NAMESPACE
