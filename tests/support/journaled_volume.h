// tests/support/journaled_volume.h: adds the rollback journal to a volume, for tests without a
// store. Test programs that use it have engine/ among their include directories.
#pragma once

#include <memory>
#include <utility>

#include "plait/backend.h"
#include "store/journaled_volume.h"
#include "store/rollback_journal.h"

namespace plait::test {

/// The journal is in the directory of the first level that is opened.
class JournaledForTest final : public Volume {
 public:
  explicit JournaledForTest(std::unique_ptr<Volume> inner) : inner_(std::move(inner)) {}

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    if (!journal_) {
      journal_ = std::make_unique<RollbackJournal>(level.directory, StoreUuid{}, 1, 1000);
      volume_ = std::make_unique<JournaledVolume>(std::move(inner_), *journal_);
    }
    return volume_->open_level(level);
  }
  std::uint64_t scratch_bytes() const noexcept override {
    return volume_ ? volume_->scratch_bytes() : 0;
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    if (volume_) volume_->begin_version(sequence, held);
  }

 private:
  std::unique_ptr<Volume> inner_;
  std::unique_ptr<RollbackJournal> journal_;
  std::unique_ptr<JournaledVolume> volume_;
};

inline BackendRegistry::Entry journaled(BackendRegistry::Entry entry) {
  entry.open = [open = entry.open](const VolumeSpec& volume) {
    return std::make_unique<JournaledForTest>(open(volume));
  };
  return entry;
}

}  // namespace plait::test
