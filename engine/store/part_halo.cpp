#include "store/part_halo.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include "format/file_names.h"
#include "plait/extend/store_access.h"
#include "store/halo_level.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Numbers of attributes that only the part has. Those of the store count up from 0.
constexpr std::uint32_t kFirstOwnNumber = std::numeric_limits<std::uint32_t>::max() - (1u << 20);

}  // namespace

void begin_halo(Store& store, AttributeId of, HaloRegion region) {
  Store::Implementation& state = StoreAccess::state(store);
  begin_change(state, Change::kAdd, "begin the halo of");
  if (!state.halo) {
    state.halo = std::make_unique<Store::Implementation::Halo>();
    state.halo->next_number = kFirstOwnNumber;
  }
  state.halo->is_open = true;
  state.halo->of = attribute_of(state, of).record.number;
  state.halo->region = std::move(region);
  state.next_number = state.halo->next_number++;
}

void end_halo(Store& store) {
  Store::Implementation& state = StoreAccess::state(store);
  begin_change(state, Change::kAdd, "end the halo of");
  if (state.halo) state.halo->is_open = false;
  state.next_number = state.first_made;
}

const Store::Implementation::Attribute& Store::Implementation::halo_source() const {
  for (const Attribute& attribute : attributes)
    if (attribute.record.number == halo->of) return attribute;
  return halo->frozen;
}

std::unique_ptr<LevelFile> Store::Implementation::open_halo_level(const StoredLevel& level,
                                                                  const AttributeSchema& schema) {
  const Attribute& frozen = halo->frozen.levels.empty() ? halo_source() : halo->frozen;
  const LevelFile& like =
      *frozen.levels.at(static_cast<std::size_t>(level.level - provenance.base_level - 1));
  const std::string name = level_file_name(level.number, level.level, sequence + 1, only_shard);
  auto file = std::make_unique<LevelFile>();
  file->geometry = like.geometry;
  file->table = like.table;
  file->path = made_in.path_of(name);
  file->attribute = schema.name;
  auto slots = std::make_unique<HaloLevel>(made_in, name, like, halo->region.edges);
  file->partly_written = slots->partly_written();
  file->backend = std::move(slots);
  pager->attach(*file);
  return file;
}

void Store::Implementation::retire(Attribute attribute) {
  if (!halo || !halo->is_open || !halo->frozen.levels.empty() ||
      attribute.record.number >= kFirstOwnNumber) {
    retire(std::move(attribute.levels));
    return;
  }
  for (auto& level : attribute.levels) pager->detach(*level);
  halo->frozen = std::move(attribute);
}

PLAIT_END_NAMESPACE
