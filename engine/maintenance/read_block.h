// Reads one block from where it is stored, whether or not the pager has it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The pager reads the blocks that are needed to decode it. REQUIRES: the pager holds no changes.
/// Errors: those of Backend::read(); kBudget if the needed blocks do not fit.
void read_block(Store& store, AttributeId attribute, int level, std::uint64_t block,
                std::span<std::byte> into);

PLAIT_END_NAMESPACE
