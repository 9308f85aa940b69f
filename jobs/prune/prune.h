// prune/prune.h: one job that copies a store and gives each face a depth of its own. `plait prune`
// is a program for it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "conversion/conversion_job.h"
#include "option_text.h"
#include "plait/detail/namespace.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_NAMESPACE

/// Exactly one of the first three members says which depths.
struct PruneRequest {
  /// The face attribute that has the finest level of each face.
  std::string depth_by = {};
  /// The largest distance between the finest level and what is drawn: a length, or a part
  /// of the diagonal of the base mesh's box.
  std::optional<RelativeLength> max_distance = {};
  std::uint64_t vertices = 0;  ///< the most vertices that are left; 0: not said
  /// Faces are made deeper until neighbours differ by at most this many levels; 0: they stay.
  int balance = 1;
  ConversionRequest copy = {};  ///< of all but the depths
};

struct PruneResult {
  ConversionResult copy;
  std::array<std::uint64_t, kMaxLevel + 1> faces_of_level = {};  ///< [finest level] faces
  std::uint64_t raised = 0;              ///< faces that `balance` has made deeper
  std::uint64_t from_vertices = 0;       ///< of the source
  std::optional<double> tolerance = {};  ///< the length of `max_distance`
  std::optional<double> distance = {};   ///< the largest that was found
};

/// Copies the levels that the depths leave. The positions are those of the attribute "position".
/// Steps: "distances" (counts faces, of each round), those of convert(). Errors: those of
/// convert(); kInvalidArgument for a face whose number is no level of the store; kNotSupported for
/// a source whose faces have depths of their own. Pinned by tests/jobs/prune_test.cpp.
PruneResult prune(const PruneRequest& request, const BackendRegistry& source_backends,
                  const BackendRegistry& backends, const JobWatch& watch = {});

PLAIT_END_NAMESPACE
