// Where the edges of a base mesh are cut into parts of equal cost.
#pragma once

#include <cstdint>
#include <vector>

#include "plait/extend/parts.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a machine of ten years ago takes; only the ratio of the two matters for the cuts.
inline constexpr double kNsPerByte = 1.3, kNsPerPoint = 5;

/// What a part costs: a record of an edge's slots is written, and read for the digest; a face is
/// refined with all its points, also if it is a ghost.
struct PartCost {
  int levels = 1;  ///< over the base mesh
  double ns_per_record = 0, ns_per_point = 0;

  std::uint64_t records(const Edge& edge) const;
  double of_edge(const Edge& edge) const {
    return ns_per_record * static_cast<double>(records(edge));
  }
  double of_face() const;
};

/// The first edges of `parts` parts. The most expensive part is as cheap as a cut along the order
/// of the edges allows. REQUIRES: 1 <= parts <= edges.
std::vector<EdgeId> cut_edges(const Topology& mesh, std::uint32_t parts, const PartCost& cost);

/// The figures of each part but its bytes.
std::vector<PlannedPart> figures_of_parts(const Topology& mesh, const std::vector<EdgeId>& starts,
                                          const PartCost& cost);

PLAIT_END_NAMESPACE
