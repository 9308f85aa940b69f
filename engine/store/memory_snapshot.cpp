#include "store/memory_snapshot.h"

#include <algorithm>
#include <utility>

#include "blocks/kept_blocks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

MemorySnapshot::MemorySnapshot(Store::Implementation& state)
    : provenance_(state.provenance),
      next_number_(state.next_number),
      face_infos_(state.face_infos),
      face_attributes_(state.face_attributes),
      texts_(state.texts) {
  for (std::size_t i = 0; i < state.attributes.size(); ++i) {
    const Store::Implementation::Attribute& attribute = state.attributes[i];
    attributes_.push_back({state.infos[i], attribute.record, attribute.base_bytes});
    for (const auto& level : attribute.levels)
      level->committed = std::make_shared<KeptBlocks>(*level);
  }
}

void MemorySnapshot::take(std::vector<std::unique_ptr<LevelFile>> levels) {
  for (auto& level : levels)
    if (level->committed) removed_.push_back(std::move(level));
}

void MemorySnapshot::restore(Store::Implementation& state) {
  for (auto& attribute : state.attributes) {
    state.retire(std::move(attribute.levels));
  }
  state.attributes.clear();
  state.infos.clear();
  for (const CommittedAttribute& committed : attributes_) {
    Store::Implementation::Attribute& attribute = state.attributes.emplace_back();
    attribute.record = committed.record;
    attribute.base_bytes = committed.base_bytes;
    state.infos.push_back(committed.info);
    for (int level = provenance_.base_level + 1; level <= committed.info.finest_level; ++level) {
      const auto found = std::ranges::find_if(removed_, [&](const auto& file) {
        return file && file->table.attribute() == committed.record.number &&
               file->table.level() == level;
      });
      LevelFile& file = **found;
      file.committed->restore(file);
      file.left_unfinished = false;
      state.pager->attach(file);
      attribute.levels.push_back(std::move(*found));
    }
  }
  removed_.clear();
  state.face_infos = face_infos_;
  state.face_attributes = face_attributes_;
  state.texts = texts_;
  state.provenance = provenance_;
  state.next_number = next_number_;
}

PLAIT_END_NAMESPACE
