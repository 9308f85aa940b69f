// What the store of a part computes for itself, beside its shard: attributes that a later pass of
// the same part reads, in the shard and in a halo around it.
#pragma once

#include <vector>

#include "plait/extend/topology.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Where a pass computes: slots of edges, and base vertices. Both ascend, and neither is empty.
struct HaloRegion {
  std::vector<EdgeId> edges;
  std::vector<VertexId> vertices;
};

/// From now on, passes of the store of open_part_store() work on `region`, and attributes that are
/// added have all slots of the attribute with the id `of`, which must have the same type: outside
/// of the region they are those of the last commit, and nothing changes them. Such attributes are
/// in files of the part's directory that are removed with them. One of them may replace `of`; the
/// next call then names that one. Until end_halo() the region does not change otherwise.
void begin_halo(Store& store, AttributeId of, HaloRegion region);

/// From now on, passes work on the shard again, and attributes that are added are the part's
/// result.
void end_halo(Store& store);

PLAIT_END_NAMESPACE
