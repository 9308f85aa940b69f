#include <fmt/format.h>
#include <lz4.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/caught.h"
#include "built_in_backends.h"
#include "compressed/coder_pool.h"
#include "compressed/extent_allocator.h"
#include "compressed/level_coder.h"
#include "level_file.h"
#include "plait/compression.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Refuses table entries that write() of this backend never makes, before the backend allocates
/// memory for a block.
void check_entries(const LevelSpec& level) {
  for (std::uint64_t block = 0; block < level.table.size(); ++block) {
    const BlockEntry& entry = level.table[block];
    const std::uint64_t raw_bytes = level.geometry.block_bytes(block);
    if (entry.encoding == BlockEncoding::kNeverWritten ||
        (entry.encoding == BlockEncoding::kRaw && entry.stored_bytes == raw_bytes) ||
        (entry.encoding == BlockEncoding::kEncoded &&
         entry.stored_bytes <= max_encoded_bytes(raw_bytes)) ||
        (entry.encoding == BlockEncoding::kPredicted && entry.stored_bytes == 0))
      continue;
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: block {}: expected {} raw bytes or at most {} encoded ones, "
                            "found {} bytes of encoding {}",
                            level.path().native(), block, raw_bytes, max_encoded_bytes(raw_bytes),
                            entry.stored_bytes, static_cast<std::uint32_t>(entry.encoding)));
  }
}

File open_level_file(const LevelSpec& level) {
  check_level(level, LZ4_MAX_INPUT_SIZE);
  check_entries(level);
  return {level.directory, level.name, level.mode};
}

/// A file of blocks, of one level or of several that are being made.
struct BlockFile {
  explicit BlockFile(const LevelSpec& level)
      : file(open_level_file(level)),
        extents(std::as_const(level.table).entries(), file.size(), file.path(), level.held) {}

  File file;
  std::mutex mutex;  ///< guards extents
  ExtentAllocator extents;
};

class CompressedLevel;
/// The open levels of a volume. The volume tells them of versions.
using OpenLevels = std::vector<CompressedLevel*>;

class CompressedLevel final : public Backend {
 public:
  /// `shared` is null, or has the coarser levels of a shared file.
  CompressedLevel(const LevelSpec& level, std::shared_ptr<BlockFile> shared, OpenPipeline pipeline,
                  CoderPool& coders, OpenLevels& open_levels)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        shares_file_(level.shares_file),
        first_block_(shared ? add_blocks(*shared, table_.size()) : 0),
        blocks_(shared ? std::move(shared) : std::make_shared<BlockFile>(level)),
        coder_(level, std::move(pipeline), tables_of(open_levels)),
        coders_(coders),
        open_levels_(open_levels) {
    open_levels_.push_back(this);
  }
  ~CompressedLevel() override { std::erase(open_levels_, this); }
  CompressedLevel(const CompressedLevel&) = delete;
  CompressedLevel& operator=(const CompressedLevel&) = delete;

  const Coding& coding() const { return coder_.coding(); }
  const std::shared_ptr<BlockFile>& file_of_blocks() const { return blocks_; }

  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
    const std::lock_guard lock(blocks_->mutex);
    blocks_->extents.begin_version(sequence, held);
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    CoderPool::Lease coder(coders_, coding());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<std::byte> raw = into.first(geometry_.block_bytes(block));
      into = into.subspan(raw.size());
      read_block(*coder, block, {}, raw);
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(blocks_->file, mode_);
    check_request(geometry_, blocks, from.size());
    CoderPool::Lease coder(coders_, coding());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<const std::byte> raw = from.first(geometry_.block_bytes(block));
      from = from.subspan(raw.size());
      write_block(*coder, block, {}, raw);
    }
  }

  void start(Transfer& transfer) noexcept override {
    if (transfer.context.empty()) return Backend::start(transfer);
    std::exception_ptr error;
    try {
      CoderPool::Lease coder(coders_, coding());
      if (transfer.direction == Transfer::Direction::kRead) {
        read_block(*coder, transfer.block, transfer.context, transfer.memory);
      } else {
        check_writable(blocks_->file, mode_);
        write_block(*coder, transfer.block, transfer.context, transfer.memory);
      }
    } catch (...) {
      error = caught_exception();
    }
    transfer.listener->finished(transfer, error);
  }

  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return coder_.context(block, blocks);
  }
  std::size_t read_context(std::uint64_t block, std::span<ContextBlock, kMostContextBlocks> blocks)
      const noexcept override {
    return coder_.read_context(block, table_[block].encoding, blocks);
  }
  bool needs_base_records(std::uint32_t attribute) const noexcept override {
    return std::ranges::any_of(table_.entries(), [&](const BlockEntry& entry) {
      return coder_.needs_base_records(entry.encoding, attribute);
    });
  }

  void advise(BlockRange, Advice advice) noexcept override {
    if (advice == Advice::kSequential) advise_sequential(blocks_->file);
  }

  void sync(bool durable) override {
    if (durable) blocks_->file.sync();
  }

  std::uint64_t stored_bytes() const override {
    if (shares_file_) return ExtentAllocator::bytes_of(std::as_const(table_).entries());
    const std::lock_guard lock(blocks_->mutex);
    return blocks_->extents.end_bytes();
  }

 private:
  static std::uint64_t add_blocks(BlockFile& file, std::uint64_t count) {
    const std::lock_guard lock(file.mutex);
    return file.extents.add_blocks(count);
  }

  static std::vector<const BlockTable*> tables_of(const OpenLevels& levels) {
    std::vector<const BlockTable*> tables;
    tables.reserve(levels.size());
    for (const CompressedLevel* const level : levels) tables.push_back(&level->table_);
    return tables;
  }

  void read_block(BlockCoder& coder, std::uint64_t block, LevelCoder::Given context,
                  std::span<std::byte> raw) {
    const BlockEntry& entry = table_[block];
    switch (entry.encoding) {
      case BlockEncoding::kNeverWritten:
        std::ranges::fill(raw, std::byte{0});
        break;
      case BlockEncoding::kRaw:
        blocks_->file.read_at(entry.offset, raw);
        table_.check(block, raw, blocks_->file.path());
        break;
      case BlockEncoding::kEncoded: {
        const std::span<std::byte> stored = coder.stored_buffer(entry.stored_bytes);
        blocks_->file.read_at(entry.offset, stored);
        table_.check(block, stored, blocks_->file.path());
        try {
          coder_.decode(coder, block, context, stored, raw);
        } catch (const Error& failure) {
          throw Error(failure.code(),
                      fmt::format("read {}: block {} at byte {}: {}", blocks_->file.path().native(),
                                  block, entry.offset, failure.what()));
        }
        break;
      }
      case BlockEncoding::kPredicted:
        coder_.make(block, context, raw);
        table_.check(block, raw, blocks_->file.path());
    }
  }

  void write_block(BlockCoder& coder, std::uint64_t block, LevelCoder::Given context,
                   std::span<const std::byte> raw) {
    if (!coder_.makes(block, context, raw))
      return write_encoded(block, coder_.encode(coder, block, context, raw));
    const BlockEntry former = table_[block];
    table_.seal_predicted(block, raw);
    const std::lock_guard lock(blocks_->mutex);
    blocks_->extents.replace(first_block_ + block, former);
  }

  /// Allocates a new extent, writes the bytes, then changes the table. So after an error the block
  /// still has its former content.
  void write_encoded(std::uint64_t block, const EncodedBlock& encoded) {
    const std::uint64_t offset = [&] {
      const std::lock_guard lock(blocks_->mutex);
      return blocks_->extents.allocate(encoded.bytes.size());
    }();
    try {
      blocks_->file.write_at(offset, encoded.bytes);
    } catch (...) {
      const std::lock_guard lock(blocks_->mutex);
      blocks_->extents.release(offset, encoded.bytes.size());
      throw;
    }
    const BlockEntry former = table_[block];
    table_.seal(block, offset, encoded.encoding, encoded.bytes);
    const std::lock_guard lock(blocks_->mutex);
    blocks_->extents.replace(first_block_ + block, former);
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  bool shares_file_;
  std::uint64_t first_block_;  ///< its number in the extents
  std::shared_ptr<BlockFile> blocks_;
  LevelCoder coder_;
  CoderPool& coders_;
  OpenLevels& open_levels_;
};

class CompressedVolume final : public Volume {
 public:
  CompressedVolume(std::shared_ptr<const PipelineRegistry> stages, const VolumeSpec& volume)
      : stages_(std::move(stages)), coders_(*stages_, volume) {}

  std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const override {
    CoderPool::Room room = coders_.room();
    std::uint64_t most = coders_.memory_of(room);
    for (const FutureLevel& level : levels) {
      const Coding coding =
          coding_of(level.pipeline,
                    stages_->open(level.pipeline, {level.schema, &level.geometry, level.attribute,
                                                   level.level, level.surroundings}));
      room = coders_.with(room, coding, level.geometry.max_block_bytes());
      most = std::max(most, coders_.memory_of(room));
    }
    return most;
  }
  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    const FilterLevel filtered{
        level.schema, &level.geometry, level.table.attribute(), level.table.level(),
        level.surroundings.attributes.empty() ? nullptr : &level.surroundings};
    const bool is_added = level.shares_file && level.mode == OpenMode::kCreate;
    std::shared_ptr<BlockFile> shared;
    if (is_added) {
      shared = shared_[level.path()].lock();
      check_level(level, LZ4_MAX_INPUT_SIZE);
    }
    auto opened = std::make_unique<CompressedLevel>(
        level, std::move(shared), stages_->open(level.pipeline, filtered), coders_, open_levels_);
    if (is_added) shared_[level.path()] = opened->file_of_blocks();
    coders_.make_room_for(opened->coding(), level.geometry.max_block_bytes());
    return opened;
  }
  std::uint64_t scratch_bytes() const noexcept override { return coders_.memory_bytes(); }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    for (CompressedLevel* const level : open_levels_) level->begin_version(sequence, held);
    coders_.shrink();
  }

 private:
  std::shared_ptr<const PipelineRegistry> stages_;
  CoderPool coders_;
  OpenLevels open_levels_;
  std::map<std::filesystem::path, std::weak_ptr<BlockFile>> shared_;  ///< that are being made
};

}  // namespace

RegisteredBackend compressed_backend(const PipelineRegistry& stages) {
  RegisteredBackend backend;
  backend.name = "compressed";
  backend.summary = "a pipeline of filters and a codec for each block (--compress)";
  backend.traits = kCompressedTraits;
  backend.stages = std::make_shared<const PipelineRegistry>(stages);
  backend.open = [shared = backend.stages](const VolumeSpec& volume) {
    return std::make_unique<CompressedVolume>(shared, volume);
  };
  backend.default_pipeline = "shuffle,zstd:1";
  backend.plain_pipeline = [](const AttributeSchema& schema) {
    return preset_pipeline("fast", schema);
  };
  return backend;
}

PLAIT_END_NAMESPACE
