// The digest of what one part of a store has.
#pragma once

#include <span>

#include "plait/digest.h"
#include "plait/extend/topology.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The sum of the hashes of the slots of a part's store (store/parts/part_store.h), and of these
/// base vertices, for these attributes. The sum of all parts and all attributes is the digest of
/// the whole store. Errors: as digest().
Digest digest_of_part(const Store& store, std::span<const VertexId> vertices,
                      std::span<const AttributeId> attributes,
                      const ProgressCallback& progress = {});

/// a + b modulo 2^128.
Digest sum_of(const Digest& a, const Digest& b);

PLAIT_END_NAMESPACE
