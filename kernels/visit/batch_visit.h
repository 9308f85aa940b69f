// visit/batch_visit.h: visits every vertex of a store once, as visit_vertices() does, for a program
// that learns the types of the records while it runs. The program gets many vertices in one call,
// in arrays: this suits languages in which a call is slow and work on arrays is fast.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/detail/visit_plan.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a visit does with an attribute.
struct BatchAttribute {
  std::string name;
  Access access = Access::kRead;
  bool rings = false;  ///< with Access::kRead: also the neighbours
};

/// The records of one attribute in a batch. Valid during the call.
struct BatchRecords {
  /// `count` records. With Access::kOverwrite they are zeros, and the call replaces them; with
  /// kUpdate it changes them.
  std::byte* records = nullptr;
  /// count * valence records, those of one vertex after those of the one before, counterclockwise.
  /// nullptr unless the visit reads rings of the attribute.
  const std::byte* neighbours = nullptr;
};

/// Vertices that have equally many neighbours. They are all inside or all on a border, and all base
/// vertices or none. If the visit reads no rings, valence is 0 and border is false.
struct VertexBatch {
  std::size_t count = 0;
  int valence = 0;
  bool border = false, base = false;
  const std::int32_t* levels = nullptr;      ///< [count] the level that creates the vertex
  const std::uint64_t* places = nullptr;     ///< [count] its number among those of its level
  const BatchRecords* attributes = nullptr;  ///< in the order of the call
};

/// Calls `visit` until every vertex of levels `first_level` to `options.level` was in exactly one
/// batch, from the calling thread. A batch has 65,536 vertices or a few more at most.
/// options.threads must be 1. Each result depends only on what `visit` reads, so the bits do not
/// depend on blocks and budget. Errors: those of visit_vertices(), and those of `visit`.
void visit_batches(Store& store, const VisitOptions& options, int first_level,
                   const std::vector<BatchAttribute>& attributes,
                   const std::function<void(const VertexBatch&)>& visit);

PLAIT_END_NAMESPACE
