// One level in several files (store/generation_volume.h).
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
  std::byte* address(std::uint64_t block) override { return home_of(block).address(block); }
  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return files_.front().backend->context(block, blocks);
  }
  void advise(BlockRange blocks, Advice advice) noexcept override;
  /// Decides which files the version has, copies blocks for a fold, and enters both in the table.
  void sync(bool durable) override;
  std::uint64_t stored_bytes() const override;

 private:
  class Renewal;

  struct OpenFile {
    Generation generation;
    std::string name;
    std::unique_ptr<Backend> backend;
  };
  /// The position of a file: in files_, or after them for new_.
  using Home = std::uint8_t;

  Home new_home() const { return static_cast<Home>(files_.size()); }
  OpenFile& file_at(Home home) { return home < files_.size() ? files_[home] : new_; }
  Backend& home_of(std::uint64_t block) { return *file_at(home_[block]).backend; }
  /// The blocks from `first` on, before `end`, that have the same home.
  BlockRange run_at(std::uint64_t first, std::uint64_t end) const;
  OpenFile open_file(const Generation& generation, OpenMode mode) const;

  /// Begins transfers of blocks that are in one file, or that are written to it.
  static void start_in(Backend& backend, std::span<Transfer* const> run) noexcept;
  /// The file that a transfer reads from or writes to. A block that is written to the new file is
  /// noted when the transfer has ended. Errors: those of target_of().
  Backend* file_of(Transfer& transfer);
  /// Where these blocks are to be written; makes the new file if that has to be.
  OpenFile& target_of(BlockRange blocks);
  void note_written(std::uint64_t block, Home home);
  bool is_stored(std::uint64_t block) const;
  void note_committed();

  bool holds_half(std::uint64_t blocks) const { return 2 * blocks >= home_.size(); }
  bool new_is_whole() const { return has_room_ || holds_half(new_blocks_); }
  std::uint64_t sparse_blocks() const;
  /// Copies the blocks of the files in [first, last] to another file, which is then their home.
  void move_blocks(Home first, Home last, Home to);
  /// Moves blocks together if that is due.
  void fold();
  /// Enters the files that still have blocks, and the file of each block, in the table.
  void enter_files();

  LevelSpec level_;
  GenerationVolume& volume_;
  std::vector<OpenFile> files_;  ///< of the committed version: the whole one, then sparse ones
  OpenFile new_;                 ///< without a backend if no block was written anew
  std::vector<Home> kept_as_;    ///< [home] its position in the next version, or kDropped
  static constexpr Home kDropped = 255;

  std::mutex making_;      ///< of new_
  bool has_room_ = false;  ///< new_ has disk space for all blocks, so the commit makes it whole
  std::atomic<bool> all_will_change_ = false;
  std::vector<bool> committed_;                ///< [block] the committed version has it
  std::vector<std::atomic<Home>> home_;        ///< [block]
  std::atomic<std::uint64_t> new_blocks_ = 0;  ///< whose home is new_
};

PLAIT_END_NAMESPACE
