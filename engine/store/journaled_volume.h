// A volume around one that overwrites in place: the blocks of the last committed version are
// entered in the rollback journal before they are overwritten.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/backend.h"
#include "store/rollback_journal.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class JournaledLevel;

class JournaledVolume final : public Volume {
 public:
  /// The journal outlives this object; begin_version() is passed on to it.
  JournaledVolume(std::unique_ptr<Volume> inner, RollbackJournal& journal);
  ~JournaledVolume() override;

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override;
  std::uint64_t scratch_bytes() const noexcept override {
    return inner_->scratch_bytes() + journal_.buffer_bytes();
  }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override;

 private:
  friend class JournaledLevel;

  std::unique_ptr<Volume> inner_;
  RollbackJournal& journal_;
  std::vector<JournaledLevel*> levels_;  ///< those that are open
};

PLAIT_END_NAMESPACE
