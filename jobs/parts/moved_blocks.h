// Blocks of a part that are elsewhere in its file than in that of the store: compressed blocks are
// in the order in which they came, which differs from run to run.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct MovedBlock {
  std::uint64_t in_store = 0, in_part = 0;  ///< offsets
  std::uint32_t bytes = 0;
};

/// Adds the blocks of a level to those of its file. Returns false if the two tables are of other
/// blocks: other bytes, or of another size.
bool add_blocks(std::span<const BlockEntry> of_store, std::span<const BlockEntry> of_part,
                std::vector<MovedBlock>& blocks);

bool are_moved(std::span<const MovedBlock> blocks);

/// Whether the two files `name` have the same blocks. False also if that of the store is missing or
/// cannot be read. Errors: those of reading the part's.
bool have_same_blocks(const Directory& store, const Directory& part, const std::string& name,
                      std::span<const MovedBlock> blocks);

/// Writes the part's blocks to a new file `name` of `to`, where they are in the store, and syncs
/// it. Errors: kIo, kNoSpace.
void write_moved(const Directory& part, const std::string& name, std::span<const MovedBlock> blocks,
                 const Directory& to);

PLAIT_END_NAMESPACE
