// One level in a file of its own and in the change log (store/generation_volume.h).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "plait/extend/backend.h"
#include "store/generation_volume.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GenerationLevel final : public Backend {
 public:
  /// The volume outlives this object.
  GenerationLevel(const LevelSpec& level, GenerationVolume& volume);
  ~GenerationLevel() override;
  GenerationLevel(const GenerationLevel&) = delete;
  GenerationLevel& operator=(const GenerationLevel&) = delete;

  /// All that was written belongs to a committed version now. REQUIRES: nobody reads or writes
  /// meanwhile.
  void begin_version();

  void read(BlockRange blocks, std::span<std::byte> into) override;
  void write(BlockRange blocks, std::span<const std::byte> from) override;
  void start(Transfer& transfer) noexcept override { start_run(std::array{&transfer}); }
  void start_run(std::span<Transfer* const> run) noexcept override;
  std::byte* address(std::uint64_t block) override;
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return file_.backend->context(block, blocks);
  }
  void advise(BlockRange blocks, Advice advice) noexcept override;
  /// Moves blocks to the new generation, or out of the former log, if there is one, and notes their
  /// places in the table. Syncs the level's own files, and not the log.
  void sync(bool durable) override;
  std::uint64_t stored_bytes() const override;

  /// Whether nothing but the log has changed since the last commit.
  bool is_in_log_alone() const { return !new_.backend && !file_has_changed_; }
  /// Whether a block is in the log.
  bool uses_log() const;
  /// Adds the blocks that were written to the log since the last commit.
  void add_changes(std::vector<ChangedBlock>& changes) const;

 private:
  class Renewal;

  struct OpenFile {
    std::uint64_t generation = 0;
    std::string name;
    std::unique_ptr<Backend> backend;
  };

  OpenFile open_file(std::uint64_t generation, OpenMode mode) const;
  Backend& backend_of(BlockPlace place) { return *(place == kInNewFile ? new_ : file_).backend; }
  /// The blocks from `first` on, before `end`, that are in the same file; one block if that is a
  /// log.
  BlockRange run_at(std::uint64_t first, std::uint64_t end) const;

  /// Begins transfers of blocks that are in one file, or that are written to it.
  static void start_in(Backend& backend, std::span<Transfer* const> run) noexcept;
  /// The file that a transfer reads from or writes to; nullptr for the log. A block that is written
  /// to the new file is noted when the transfer has ended. Errors: those of target_of().
  Backend* file_of(Transfer& transfer);
  void move_in_log(Transfer& transfer) noexcept;
  /// Where the block is to be written: kInLog stands for the log. Makes the new file if that has to
  /// be.
  BlockPlace target_of(std::uint64_t block);
  void make_new_file();
  bool is_stored(std::uint64_t block) const;
  void read_from_log(std::uint64_t block, std::span<std::byte> into);
  void write_to_log(std::uint64_t block, std::span<const std::byte> from);

  std::uint64_t count_in_log() const;
  /// Copies all blocks to the new file.
  void fill_new_file();
  /// Moves blocks from the former log to the new one, or to their places in the level's file, if
  /// `to_level_file` and neither the newest version nor a reader needs what is there.
  void leave_former_log(bool to_level_file);

  LevelSpec level_;
  GenerationVolume& volume_;
  OpenFile file_;  ///< of the committed version
  OpenFile new_;   ///< the next generation; without a backend if there is none
  std::vector<std::atomic<BlockPlace>> places_;  ///< [block]
  std::vector<bool> committed_;                  ///< [block] the committed version has it

  std::mutex making_;                   ///< of new_, and of what follows
  std::vector<std::uint64_t> changed_;  ///< blocks that were written to the log, each once
  std::atomic<bool> all_will_change_ = false, file_has_changed_ = false;
};

PLAIT_END_NAMESPACE
