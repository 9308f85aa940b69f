// The passes of a subdivision, for the sweep and for the transparent executor. Levels are numbered
// as in the store.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "plait/detail/one_ring.h"
#include "plait/detail/ring_table.h"
#include "plait/extend/store_access.h"
#include "plait/extend/sweep.h"
#include "plait/extend/vector3.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "schemes/butterfly.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The parts of PlannedSubdivision::needs(), of options whose executor and threads are chosen.
std::uint64_t frames_of_subdivision(const Store& store, const SubdivideOptions& options,
                                    bool makes_levels);
std::uint64_t resident_of_subdivision(const Store& store, const SubdivideOptions& options);

/// The data that all passes of one run share.
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
  /// The rings of the base vertices at the finest finished level. (The fused executor has its own
  /// rings.)
  RingTable<Vector3<Real>> rings;
  std::uint64_t vertices_before = 0, vertices_total = 0;

  /// Reports `done` of `count` equal parts of a pass over `vertices` vertices; throws kCancelled.
  void report(std::string_view phase, std::uint64_t vertices, std::uint64_t done,
              std::uint64_t count) const;
};

/// The accesses of the sweeps of one level, and of the sweep over the finished surface; kNoId as
/// for make_surface(). The sweeps take them, and so does the sum of the frames that a subdivision
/// needs, before there are such levels.
std::vector<LevelAccess> odd_accesses(AttributeId position, int base_level, int level,
                                      int ring_count);
std::vector<LevelAccess> even_accesses(AttributeId position, int base_level, int level);
std::vector<LevelAccess> surface_accesses(AttributeId position, int base_level, int level,
                                          AttributeId normal, AttributeId limit);

/// The number of vertices that levels `first` to `last` create.
inline std::uint64_t vertices_born(const Store& store, int first, int last) {
  std::uint64_t vertices = 0;
  for (int level = first; level <= last; ++level)
    vertices += StoreAccess::geometry(store, 1, level).total_bytes();
  return vertices;
}

// `Rule` is OneRing<Real> or Butterfly<Real>: with_rule() chooses it once for each run.

/// Computes the vertices that `level` creates, and the rings of the base vertices.
template <class Rule>
void make_odd(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level);
/// Moves the vertices of the levels between the base mesh and `level`. REQUIRES: there are some,
/// rule.moves_even().
template <class Real>
void move_even(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level);
/// Fills the attributes `normal` (float32 x 3) and `limit` (same type as the positions) on all
/// levels up to `level`, but not their base records. kNoId: not wanted. REQUIRES: there are levels.
template <class Rule>
void make_surface(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                  AttributeId normal, AttributeId limit);
/// Reads the rings of the base vertices at `level` from the store.
template <class Real>
void read_rings(SubdivisionRun<Real>& run, int level);

/// The same passes with the transparent executor.
template <class Rule>
void make_odd_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level);
template <class Real>
void move_even_transparent(SubdivisionRun<Real>& run, const OneRing<Real>& rule, int level);
template <class Rule>
void make_surface_transparent(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, int level,
                              AttributeId normal, AttributeId limit);

/// Computes all levels, and normals or limit positions, in one pass of the fused executor.
/// REQUIRES: the attributes have all levels up to options.levels. `normal` may be kNoId. With
/// options.limit, the positions are limit positions.
template <class Rule>
void run_fused(SubdivisionRun<typename Rule::Real>& run, const Rule& rule, AttributeId normal);
/// The memory that run_fused() uses in addition to the budget.
template <class Rule>
std::uint64_t fused_resident_bytes(const Store& store, const SubdivideOptions& options);

PLAIT_END_NAMESPACE
