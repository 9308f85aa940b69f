#include "store/generation_volume.h"

#include <utility>

#include "store/generation_level.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

GenerationVolume::GenerationVolume(std::unique_ptr<Volume> inner, const Directory& store,
                                   std::uint64_t sequence, std::span<const std::uint64_t> held)
    : inner_(std::move(inner)), store_(store), sequence_(sequence), has_held_(!held.empty()) {}

GenerationVolume::~GenerationVolume() = default;

std::unique_ptr<Backend> GenerationVolume::open_level(const LevelSpec& level) {
  if (level.mode == OpenMode::kRead && level.table.generations().size() == 1)
    return inner_->open_level(level);
  return std::make_unique<GenerationLevel>(level, *this);
}

void GenerationVolume::begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
  inner_->begin_version(sequence, held);
  for (GenerationLevel* const level : levels_) level->begin_version();
  sequence_ = sequence;
  has_held_ = !held.empty();
}

PLAIT_END_NAMESPACE
