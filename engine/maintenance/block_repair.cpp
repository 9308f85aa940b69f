#include "maintenance/block_repair.h"

#include <algorithm>

#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::optional<std::string> BlockRepair::why_lost(const BlockAddress& block) {
  const AttributeSchema& schema = store_.attributes()[block.attribute].schema;
  LevelFile& level = StoreAccess::level_file(store_, block.attribute, block.level);
  // Alone, such a block cannot be proven; and blocks that others are encoded from cannot change.
  if (level.is_fixed || level.backend->needs_base_records(level.table.attribute()))
    return "it is encoded from other blocks, and repair cannot encode it again";
  const auto is_lost_one = [&](const MadeAgain::Records& made) {
    return made && proof_.stored_bytes(level, schema, block.block, *made);
  };
  bool is_made = false;
  MadeAgain::Records made;
  for (const auto from : {MadeAgain::From::kBaseMesh, MadeAgain::From::kAttributes}) {
    made = made_.block(from, schema.name, level.geometry, block.block);
    is_made |= made.has_value();
    if (is_lost_one(made)) break;
    made.reset();
  }
  if (!made) return is_made ? "what is made again is not what it held" : made_.refusal();
  if (options_.dry_run) return std::nullopt;
  const PinnedBlock to =
      StoreAccess::open_session(store_).pin(level, block.block, Access::kOverwrite);
  std::ranges::copy(*made, to.bytes().begin());
  return std::nullopt;
}

PLAIT_END_NAMESPACE
