// Computes the normals of the slot of an edge at one level, with the neighbours that its vertices
// have at the finest level. It copies the neighbours into rows first, because they lie in another
// order in each slot, and then computes whole rows in registers. Pinned by
// tests/kernels/made_normals_test.cpp.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/regular_normal.h"
#include "plait/detail/edge_grid.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"
#include "predicted/finest_neighbours.h"
#include "predicted/source_slots.h"
#include "rows/record_normals.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Only one thread at a time may use an object.
template <class Real>
class SlotNormals {
  using Point = Vector3<Real>;
  using Normal = Vector3<float>;
  using Finest = FinestNeighbours<Point>;

 public:
  SlotNormals(int own, int finest)
      : own_(own), finest_(finest), points_(point_count(own, finest)) {}

  static std::uint64_t memory_bytes(int own, int finest) {
    return point_count(own, finest) * sizeof(Point);
  }

  /// `slots` has the slots that SourceBlocks names for the edge, `base` the base vertices.
  void compute(const Topology& mesh, const SourceSlots<Point>& slots, std::span<const Point> base,
               EdgeId edge, Normal* to) {
    const Finest at(mesh, slots, edge, finest_);
    const Point* const border =
        mesh.edges[edge].is_border() ? slots.slot(own_, edge).data() : nullptr;
    if (own_ == finest_) {
      copy_coarser(mesh, slots, base, edge);
      compute_finest(at, border, to);
    } else {
      compute_coarser(at, border, to);
    }
  }

  /// Begins to load the slots from which compute() copies. The records of a run are far apart, so
  /// the processor does not load them ahead by itself: without this function, a digest of a store
  /// takes a quarter longer to make the normals (docs/made-blocks.md).
  void prefetch(const Topology& mesh, const SourceSlots<Point>& slots, EdgeId edge) const {
    constexpr std::size_t kMostBytes = 16 << 10;  // of one slot: they share the nearest cache
    for (const FaceSide face : {mesh.edges[edge].own, mesh.edges[edge].other})
      if (face.exists())
        for (const EdgeId around : mesh.face_edges[face.face()])
          for (int level = own_ == finest_ ? 1 : finest_; level <= finest_; ++level) {
            const auto records = std::as_bytes(slots.slot(level, around).records);
            const std::size_t end = std::min(records.size(), kMostBytes);
            for (std::size_t at = 0; at < end; at += 64) __builtin_prefetch(&records[at]);
          }
  }

 private:
  /// As many vertices of a coarser level are computed at once, unless one row has more.
  static constexpr std::int64_t kBatch = 256;

  /// At the finest level, the rows after those of the neighbours across the edge.
  static constexpr std::int64_t kCoarser = 3;

  static std::int64_t batch_rows(int level) {
    return std::max<std::int64_t>(1, kBatch / slot_side(level));
  }
  static std::int64_t row_points(int own, int finest) {
    const std::int64_t n = slot_side(own);
    return own == finest ? n + 1 : std::min(n, batch_rows(own)) * n;
  }
  static std::size_t point_count(int own, int finest) {
    const std::int64_t rows = own == finest ? kCoarser + slot_side(own) + 1 : 6;
    return static_cast<std::size_t>(rows * row_points(own, finest)) + kPatchLanes;
  }

  Point* row(std::int64_t number) { return points_.data() + row_points(own_, finest_) * number; }
  /// The point (2 i, 2 j) of the edge's grid, which a coarser level has created.
  Point* coarser(std::int64_t i, std::int64_t j) { return row(kCoarser + i) + j; }

  /// Copies the points that coarser levels than the finest one have created.
  void copy_coarser(const Topology& mesh, const SourceSlots<Point>& slots,
                    std::span<const Point> base, EdgeId edge) {
    GridShape shape(finest_ - 1);
    shape.stride = row_points(own_, finest_);
    for_each_around(
        mesh, edge, shape, base, slots, {0, finest_ - 1},
        [to = coarser(0, 0)](std::int64_t point, const Point& from) { to[point] = from; });
  }

  /// Both coordinates of the vertices are odd, so only their neighbours along the edge are points
  /// of coarser levels.
  void compute_finest(const Finest& at, const Point* border, Normal* to) {
    const std::int64_t n = slot_side(own_);
    const auto records = [&](std::int64_t i) { return border ? n - i : n; };
    at.copy_across_p({0, 1, 2, records(0)}, row(0));
    for (std::int64_t i = 0; i < n; ++i) {
      const Point* const before = row(i % 2);
      Point *const after = row((i + 1) % 2), *const across = row(2);
      at.copy_across_p({2 * i + 2, 1, 2, records(i + 1)}, after);
      at.copy_across_q({2 * i + 1, 0, 2, border ? n - i : n + 1}, across);
      const std::int64_t inside = records(i) - (border ? 1 : 0);
      compute_row_({{{after, before}, {across + 1, across}, {coarser(i, 1), coarser(i + 1, 0)}},
                    inside,
                    to});
      to += inside;
      if (!border) continue;
      border += inside;
      const std::int64_t p = 2 * i + 1, q = 2 * inside + 1;
      *to++ = RegularNormal::border(*border++, *coarser(i, inside + 1), *at.across_p(p - 1, q),
                                    *at.across_q(p, q - 1), *coarser(i + 1, inside));
    }
  }

  /// All neighbours are points of the finest level.
  void compute_coarser(const Finest& at, const Point* border, Normal* to) {
    const std::int64_t n = slot_side(own_), scale = std::int64_t{1} << (finest_ - own_);
    const std::int64_t rows = border ? 1 : std::min(n, batch_rows(own_));
    for (std::int64_t first = 0; first < n; first += rows) {
      const std::int64_t inside = border ? n - 1 - first : n;
      for (std::int64_t i = 0; i < rows; ++i) {
        const std::int64_t p = (2 * (first + i) + 1) * scale, q = scale;
        const auto run = [&](std::int64_t of_p, std::int64_t of_q) {
          return GridRun{of_p, of_q, 2 * scale, inside};
        };
        at.copy_across_q(run(p + 1, q), row(0) + i * n);
        at.copy_across_q(run(p - 1, q), row(1) + i * n);
        at.copy_across_p(run(p, q + 1), row(2) + i * n);
        at.copy_across_p(run(p, q - 1), row(3) + i * n);
        at.copy_along(run(p - 1, q + 1), row(4) + i * n);
        at.copy_along(run(p + 1, q - 1), row(5) + i * n);
      }
      compute_row_({{{row(0), row(1)}, {row(2), row(3)}, {row(4), row(5)}}, rows * inside, to});
      to += rows * inside;
      if (!border) continue;
      border += inside;
      const std::int64_t p = (2 * first + 1) * scale, q = (2 * inside + 1) * scale;
      *to++ = RegularNormal::border(*border++, *at.along(p - 1, q + 1), *at.across_q(p - 1, q),
                                    *at.across_p(p, q - 1), *at.along(p + 1, q - 1));
    }
  }

  int own_, finest_;
  std::vector<Point> points_;  ///< row by row
  RecordNormalsRow<Real> compute_row_ = record_normals_row<Real>();
};

PLAIT_END_NAMESPACE
