// maintenance/decoded_again.h: says when a budget was too small to decode each block once.
#pragma once

#include <string>

#include "plait/detail/namespace.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// After a pass over all blocks of a store in order: how often they were read on average, if the
/// blocks that others are decoded with did not fit the budget. Empty if each block was read about
/// once. Counts what the store has read since it was opened.
std::string decoded_again(const Store& store);

PLAIT_END_NAMESPACE
