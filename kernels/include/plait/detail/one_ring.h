// plait/detail/one_ring.h: a one-ring rule as a table of functions for the executors. They compute
// one vertex, one slot, or one row of sixteen patches per call. The library's rules and a program's
// own rules both have this form.
#pragma once

#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "plait/detail/edge_grid.h"
#include "plait/detail/namespace.h"
#include "plait/detail/one_ring_rule.h"
#include "plait/detail/rows.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// The first argument of each function is the rule. functions_of() makes the table
/// (plait/own_rule.h).
template <class Real>
struct OneRingFunctions {
  using Point = Vector3<Real>;
  using WidePoint = Vector3<double>;
  using Grid = EdgeGrid<Point>;

  bool reads_ends_only;
  // One vertex.
  Point (*odd)(const void* rule, const Point& a, const Point& b, const Point& c, const Point& d);
  Point (*odd_border)(const void* rule, const Point& a, const Point& b);
  Point (*even)(const void* rule, const Point& v, const Point& ring);
  Point (*even_border)(const void* rule, const Point& v, const Point& p, const Point& q);
  Point (*limit)(const void* rule, const Point& v, const Point& ring);
  Point (*limit_border)(const void* rule, const Point& v, const Point& p, const Point& q);
  // A base vertex.
  WidePoint (*even_base)(const void* rule, const BaseRing& ring, bool border, const WidePoint& v);
  WidePoint (*limit_base)(const void* rule, const BaseRing& ring, bool border, const WidePoint& v);
  // A slot, from the grid of its edge.
  void (*odd_slot)(const void* rule, const Grid& grid, const SlotRows& rows, Point* slot);
  void (*even_slot)(const void* rule, const Grid& grid, int level, const SlotRows& rows,
                    Point* slot);
  void (*limit_slot)(const void* rule, const Grid& grid, int level, const SlotRows& rows,
                     Point* slot);
  // Rows of a group of patches, and the rings of base vertices.
  void (*odd_row)(const void* rule, const OddRow<Real>& row);
  void (*even_row)(const void* rule, const EvenRow<Real>& row);
  void (*limit_row)(const void* rule, const SurfaceRow<Real, Real>& row);
  void (*ring_step)(const void* rule, const RingStep<Real>& step);
};

/// A rule for points of float or double. Copies share the rule, which never changes. Safe from any
/// number of threads. No call fails. REQUIRES: moves_even() for functions that move even vertices,
/// has_limits() for functions that compute limit positions.
template <class RealType>
class OneRing {
 public:
  using Real = RealType;
  using Point = Vector3<Real>;
  /// How many rings around a vertex the rule reads.
  static constexpr int kRingCount = 1;

  OneRing(std::shared_ptr<const void> rule, const OneRingFunctions<Real>& functions)
      : rule_(std::move(rule)), functions_(functions) {}

  bool moves_even() const { return functions_.even != nullptr; }
  bool has_limits() const { return functions_.limit != nullptr; }
  /// Whether odd() equals odd_border() of its first two points.
  bool reads_ends_only() const { return functions_.reads_ends_only; }

  /// A new vertex on the edge between `a` and `b`; `c` and `d` lie opposite. odd_border(): the same
  /// on a border, between `a` and `b`.
  Point odd(const Point& a, const Point& b, const Point& c, const Point& d) const {
    return functions_.odd(rule_.get(), a, b, c, d);
  }
  Point odd_border(const Point& a, const Point& b) const {
    return functions_.odd_border(rule_.get(), a, b);
  }
  /// The new position of an even vertex of valence 6, from the ring_sum() of its new neighbours. On
  /// a border, from its two new neighbours on the border.
  Point even(const Point& v, const Point& ring) const {
    return functions_.even(rule_.get(), v, ring);
  }
  Point even_border(const Point& v, const Point& p, const Point& q) const {
    return functions_.even_border(rule_.get(), v, p, q);
  }
  /// The limit position of a vertex, from its neighbours at the finest level in the same form.
  Point limit(const Point& v, const Point& ring) const {
    return functions_.limit(rule_.get(), v, ring);
  }
  Point limit_border(const Point& v, const Point& p, const Point& q) const {
    return functions_.limit_border(rule_.get(), v, p, q);
  }
  /// The same for a base vertex. If it is on a border, the first and the last neighbour of the ring
  /// are on the border.
  Vector3<double> even_base(const BaseRing& ring, bool border, const Vector3<double>& v) const {
    return functions_.even_base(rule_.get(), ring, border, v);
  }
  Vector3<double> limit_base(const BaseRing& ring, bool border, const Vector3<double>& v) const {
    return functions_.limit_base(rule_.get(), ring, border, v);
  }

  /// Computes the slot at level grid.level() + 1.
  void odd_slot(const EdgeGrid<Point>& grid, const SlotRows& rows, Point* slot) const {
    functions_.odd_slot(rule_.get(), grid, rows, slot);
  }
  /// Moves the vertices of the slot at `level`, which is coarser than the grid.
  void even_slot(const EdgeGrid<Point>& grid, int level, const SlotRows& rows, Point* slot) const {
    functions_.even_slot(rule_.get(), grid, level, rows, slot);
  }
  void limit_slot(const EdgeGrid<Point>& grid, int level, const SlotRows& rows, Point* slot) const {
    functions_.limit_slot(rule_.get(), grid, level, rows, slot);
  }

  void odd_row(const OddRow<Real>& row) const { functions_.odd_row(rule_.get(), row); }
  void even_row(const EvenRow<Real>& row) const { functions_.even_row(rule_.get(), row); }
  void limit_row(const SurfaceRow<Real, Real>& row) const {
    functions_.limit_row(rule_.get(), row);
  }
  void ring_step(const RingStep<Real>& step) const { functions_.ring_step(rule_.get(), step); }

 private:
  std::shared_ptr<const void> rule_;
  OneRingFunctions<Real> functions_;
};

/// A one-ring rule with a name, for positions in either precision. own_scheme() makes one from a
/// program's own rule (plait/own_rule.h).
class OneRingScheme {
 public:
  OneRingScheme(std::string name, const OneRing<float>& in_float, const OneRing<double>& in_double)
      : name_(std::move(name)), in_float_(in_float), in_double_(in_double) {}

  const std::string& name() const { return name_; }
  template <class Real>
  const OneRing<Real>& rule() const {
    if constexpr (std::is_same_v<Real, float>)
      return in_float_;
    else
      return in_double_;
  }

 private:
  std::string name_;
  OneRing<float> in_float_;
  OneRing<double> in_double_;
};

/// The schemes of the library.
const OneRingScheme& loop_scheme();
const OneRingScheme& midpoint_scheme();

PLAIT_END_NAMESPACE
