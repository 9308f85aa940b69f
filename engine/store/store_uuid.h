// The UUID of a store that is being made.
#pragma once

#include "plait/extend/block_table.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Gives a new store, which has no attributes and no commit yet, this UUID instead of a random one.
/// Errors: kBadState for another store.
void set_uuid(Store& store, const StoreUuid& uuid);

PLAIT_END_NAMESPACE
