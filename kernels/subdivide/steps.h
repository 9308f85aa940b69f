// The passes that make up a subdivision, each by either executor that has passes. Levels are the
// store's numbers.
#pragma once

#include <functional>
#include <string>

#include "plait/kernels/one_ring.h"
#include "plait/kernels/ring_table.h"
#include "plait/kernels/subdivide.h"
#include "plait/store.h"
#include "plait/vector3.h"
#include "schemes/butterfly.h"

namespace plait {

/// What all passes of one run share.
template <class Real>
struct SubdivisionRun {
  SubdivisionRun(Store& store_to_refine, const SubdivideOptions& run_options, AttributeId id)
      : store(store_to_refine),
        options(run_options),
        position(id),
        rings(options.executor == ExecutorKind::kFused ? 0 : store.base().edge_count()) {}

  Store& store;
  const SubdivideOptions& options;
  AttributeId position;
  /// Rings of the base vertices at the finest level done; the fused executor has its own.
  RingTable<Vector3<Real>> rings;
  std::uint64_t vertices_before = 0, vertices_total = 0;

  /// Reports `done` of `count` equal parts of a pass over `vertices` vertices; throws kCancelled.
  void report(std::string_view phase, std::uint64_t vertices, std::uint64_t done,
              std::uint64_t count) const;
};

// `Rule` is OneRing<Real> or Butterfly<Real>: with_rule() chooses it once a run.

/// Vertices born at `level`, and their rings.
template <class Rule>
void make_odd(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level);
/// Moves the vertices born before `level`, base vertices included. REQUIRES: rule.moves_even().
template <class Real>
void move_even(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level);
/// Fills attributes `normal` (float32 x 3) and `limit` (as the positions) over all levels to
/// `level`; kNoId leaves one out.
template <class Rule>
void make_surface(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                  AttributeId normal, AttributeId limit);
/// Rings of the base vertices at `level`, read from the store.
template <class Real>
void read_rings(SubdivisionRun<Real>& run, int level);

/// The same by the transparent executor.
template <class Rule>
void make_odd_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level);
template <class Real>
void move_even_transparent(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level);
template <class Rule>
void make_surface_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                              AttributeId normal, AttributeId limit);

/// All levels and the surface at once, by the fused executor, into attributes that have all levels
/// to options.levels already; `normal` may be kNoId. With options.limit positions are limit
/// positions.
template <class Rule>
void run_fused(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, AttributeId normal);
/// What run_fused keeps beside the budget.
template <class Rule>
std::uint64_t fused_resident_bytes(const Store& store, const SubdivideOptions& options);

}  // namespace plait
