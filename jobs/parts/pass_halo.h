// Several iterations of a pass in one plan: each part computes all but the last one also in a halo
// of base faces around it, so it needs no result of other parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "parts/cuts.h"
#include "plait/extend/parts.h"
#include "plait/extend/topology.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The iterations of a plan, and how often the base mesh is refined to reach the finest level.
struct PassIterations {
  std::uint32_t count = 1;
  int refinements = 1;

  /// The rings of base faces (mesh/face_rings.h) in which a part computes an iteration that `left`
  /// others follow. The last one needs right values at the part's vertices, the one before also
  /// one step further at the finest level, and so on; all vertices that are r 2^refinements steps
  /// away or less are in r rings. A pass of the library that reads no neighbours needs no ring.
  std::size_t rings(const Pass& pass, std::uint32_t left) const;
};

/// Errors: kInvalidArgument for a pass that cannot be iterated in one plan, and for more iterations
/// than a plan may have.
void check_iterations(const Pass& pass, const PassIterations& iterations);

/// Makes the figures of parts those of all iterations. `parts` have those of one.
void add_iterations(std::vector<PlannedPart>& parts, const Topology& mesh, const PartCost& cost,
                    const Pass& pass, const PassIterations& iterations);

/// Makes the result of all iterations in the store of a part (open_part_store()). Returns its id.
/// Errors: those of run_pass().
AttributeId make_iterations(Store& store, const Pass& pass, const PassIterations& iterations,
                            const VisitOptions& options);

PLAIT_END_NAMESPACE
