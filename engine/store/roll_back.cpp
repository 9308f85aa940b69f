// Brings a store back to its last commit.
#include <fmt/format.h>

#include <utility>

#include "plait/error.h"
#include "plait/store.h"
#include "store/generation_volume.h"
#include "store/memory_snapshot.h"
#include "store/recovery.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void Store::Implementation::retire(std::vector<std::unique_ptr<LevelFile>> levels) {
  // Blocks of finer levels hold those of coarser ones that they are encoded from.
  for (auto level = levels.rbegin(); level != levels.rend(); ++level) pager->detach(**level);
  if (snapshot) snapshot->take(std::move(levels));
}

void Store::Implementation::reread() {
  StoredVersion version(directory, open_newest_version(directory));
  for (Attribute& attribute : attributes) retire(std::move(attribute.levels));
  attributes.clear();
  infos.clear();
  face_attributes.clear();
  face_infos.clear();
  try {
    if (generations) generations->roll_back();
    versions_read = remove_old_versions(directory);
    next_number = version.description().next_attribute_number;
    provenance = version.description().provenance;
    hold_versions();
    read_version(version, OpenMode::kReadWrite);
    held.clear();
  } catch (...) {
    failed = true;
    pager->refuse_writes();
    throw;
  }
}

void Store::roll_back() try {
  Implementation& state = this->state();
  begin_change(state, Change::kRemove, "roll back");
  if (state.failed)
    throw Error(ErrorCode::kBadState,
                fmt::format("roll back {}: refused because an earlier commit failed; reopen the "
                            "store",
                            state.name()));
  state.pager->discard();
  if (state.snapshot) {
    state.snapshot->restore(state);
  } else if (state.sequence > 0) {
    state.reread();
  } else {
    for (auto& attribute : state.attributes) state.retire(std::move(attribute.levels));
    state.attributes.clear();
    state.infos.clear();
    state.face_attributes.clear();
    state.face_infos.clear();
    state.texts.clear();
    state.provenance = state.first_provenance;
    state.next_number = 0;
  }
  if (state.sequence > 0) {
    state.find_changed_records();
    state.note_committed();
  }
} catch (const std::bad_alloc&) {
  throw out_of_memory("roll back " + state().name());
}

PLAIT_END_NAMESPACE
