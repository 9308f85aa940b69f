// A backend that writes in place, with the blocks of the last committed version entered in the
// rollback journal before they are overwritten.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "plait/backend.h"
#include "store/rollback_journal.h"

namespace plait {

class GuardedBackend final : public Backend {
 public:
  /// `inner` is durable and keeps blocks at the geometry's offsets. What `level` refers to outlives
  /// this object, and so does the journal.
  GuardedBackend(std::unique_ptr<Backend> inner, const LevelSpec& level, std::uint32_t attribute,
                 int level_number, RollbackJournal& journal);

  BackendTraits traits() const noexcept override { return inner_->traits(); }
  void read(BlockRange blocks, std::span<std::byte> into) override { inner_->read(blocks, into); }
  void write(BlockRange blocks, std::span<const std::byte> from) override;
  void start(Transfer& transfer) noexcept override;
  std::byte* address(std::uint64_t block, bool writable) override;
  void advise(BlockRange blocks, Advice advice) noexcept override {
    inner_->advise(blocks, advice);
  }
  void sync(bool durable) override { inner_->sync(durable); }
  std::uint64_t stored_bytes() const override { return inner_->stored_bytes(); }

 private:
  void keep(BlockRange blocks);

  std::unique_ptr<Backend> inner_;
  const LevelGeometry& geometry_;
  const BlockTable& table_;
  std::uint32_t attribute_;
  int level_number_;
  RollbackJournal& journal_;

  std::mutex mutex_;
  std::uint64_t sequence_;         ///< of the version that unkept_ is about
  std::vector<bool> unkept_;       ///< [block] is of that version, and not in the journal
  std::uint64_t next_ = 0;         ///< the block after those entered last
  std::uint64_t ahead_bytes_ = 0;  ///< entered beside what was asked for
};

}  // namespace plait
