#include "compressed/compressed_backend.h"

#include <fmt/format.h>
#include <lz4.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "compressed/codec_timer.h"
#include "compressed/coder_pool.h"
#include "compressed/extent_allocator.h"
#include "compressed/level_context.h"
#include "level_file.h"
#include "plait/backends/compression.h"
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

class CompressedBackend;
/// The open levels of a volume. The volume tells them of versions.
using OpenLevels = std::vector<CompressedBackend*>;

class CompressedBackend final : public Backend {
 public:
  CompressedBackend(const LevelSpec& level, Pipeline pipeline, CoderPool& coders,
                    OpenLevels& open_levels)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        file_(open_level_file(level)),
        extents_(std::as_const(table_).entries(), file_.size(), file_.path(), level.held),
        filters_(std::move(pipeline.filters)),
        context_(level, filters_, tables_of(open_levels)),
        maker_(std::move(pipeline.maker)),
        why_no_maker_(std::move(pipeline.why_no_maker)),
        coding_{level.pipeline, std::min<std::size_t>(filters_.size(), 2), scratch_bytes(filters_),
                maker_ ? maker_->scratch_bytes() : 0},
        coders_(coders),
        open_levels_(open_levels) {
    open_levels_.push_back(this);
  }
  ~CompressedBackend() override { std::erase(open_levels_, this); }
  CompressedBackend(const CompressedBackend&) = delete;
  CompressedBackend& operator=(const CompressedBackend&) = delete;

  const Coding& coding() const { return coding_; }

  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
    const std::lock_guard lock(mutex_);
    extents_.begin_version(sequence, held);
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    CoderPool::Lease coder(coders_, coding_);
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<std::byte> raw = into.first(geometry_.block_bytes(block));
      into = into.subspan(raw.size());
      read_block(*coder, block, {}, raw);
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    CoderPool::Lease coder(coders_, coding_);
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
      CoderPool::Lease coder(coders_, coding_);
      if (transfer.direction == Transfer::Direction::kRead) {
        read_block(*coder, transfer.block, transfer.context, transfer.memory);
      } else {
        check_writable(file_, mode_);
        write_block(*coder, transfer.block, transfer.context, transfer.memory);
      }
    } catch (...) {
      error = std::current_exception();
    }
    transfer.listener->finished(transfer, error);
  }

  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    return context_.blocks_for(block, blocks);
  }
  bool reads_alone(std::uint64_t block) const noexcept override {
    return table_[block].encoding == BlockEncoding::kPredicted;
  }
  bool needs_base_records() const noexcept override {
    return context_.base_attribute() == table_.attribute();
  }

  void advise(BlockRange blocks, Advice advice) noexcept override {
    if (advice == Advice::kSequential || advice == Advice::kRandom)  // applies to the whole file
      return advise_file(file_, {0, stored_bytes()}, advice);
    const std::uint64_t first = std::min(blocks.first, table_.size());
    const std::uint64_t end = first + std::min(blocks.count, table_.size() - first);
    for (std::uint64_t block = first; block < end; ++block) {
      // The lock is needed: another thread may be writing this block.
      const BlockEntry entry = [&] {
        const std::lock_guard lock(mutex_);
        return table_[block];
      }();
      if (entry.stored_bytes > 0) advise_file(file_, {entry.offset, entry.stored_bytes}, advice);
    }
  }

  void sync(bool durable) override {
    if (durable) file_.sync();
  }

  std::uint64_t stored_bytes() const override {
    const std::lock_guard lock(mutex_);
    return extents_.end_bytes();
  }

 private:
  using Context = std::span<const std::span<const std::byte>>;

  static std::vector<const BlockTable*> tables_of(const OpenLevels& levels) {
    std::vector<const BlockTable*> tables;
    tables.reserve(levels.size());
    for (const CompressedBackend* const level : levels) tables.push_back(&level->table_);
    return tables;
  }

  void read_block(BlockCoder& coder, std::uint64_t block, Context context,
                  std::span<std::byte> raw) {
    const BlockEntry& entry = table_[block];
    switch (entry.encoding) {
      case BlockEncoding::kNeverWritten:
        std::ranges::fill(raw, std::byte{0});
        break;
      case BlockEncoding::kRaw:
        file_.read_at(entry.offset, raw);
        table_.check(block, raw, file_.path());
        break;
      case BlockEncoding::kEncoded: {
        const std::span<std::byte> stored = coder.stored_buffer(entry.stored_bytes);
        file_.read_at(entry.offset, stored);
        table_.check(block, stored, file_.path());
        decode(coder, block, context, stored, raw);
        break;
      }
      case BlockEncoding::kPredicted:
        if (!maker_)
          throw Error(ErrorCode::kNotSupported,
                      fmt::format("read {}: block {} is predicted and cannot be made again: {}",
                                  file_.path().native(), block,
                                  why_no_maker_.empty() ? "its level has no stage `predicted`"
                                                        : why_no_maker_));
        make(block, raw);
        table_.check(block, raw, file_.path());
    }
  }

  void make(std::uint64_t block, std::span<std::byte> raw) const {
    const CodecTimer timer;
    maker_->make(block, raw);
  }
  bool makes(std::uint64_t block, std::span<const std::byte> raw) const {
    const CodecTimer timer;
    return maker_->makes(block, raw);
  }

  void write_block(BlockCoder& coder, std::uint64_t block, Context context,
                   std::span<const std::byte> raw) {
    if (maker_ && makes(block, raw)) {
      const BlockEntry former = table_[block];
      const std::lock_guard lock(mutex_);
      table_.seal_predicted(block, raw);
      return extents_.replace(block, former);
    }
    write_encoded(
        block, coder.encode({filters_, {block, context, {}}, context_.seal(block, context)}, raw));
  }

  /// Allocates a new extent, writes the bytes, then changes the table. So after an error the block
  /// still has its former content.
  void write_encoded(std::uint64_t block, const EncodedBlock& encoded) {
    const std::uint64_t offset = [&] {
      const std::lock_guard lock(mutex_);
      return extents_.allocate(encoded.bytes.size());
    }();
    try {
      file_.write_at(offset, encoded.bytes);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      extents_.release(offset, encoded.bytes.size());
      throw;
    }
    const BlockEntry former = table_[block];
    const std::lock_guard lock(mutex_);
    table_.seal(block, offset, encoded.encoding, encoded.bytes);
    extents_.replace(block, former);
  }

  void decode(BlockCoder& coder, std::uint64_t block, Context context,
              std::span<const std::byte> stored, std::span<std::byte> raw) {
    try {
      coder.decode({filters_, {block, context, {}}, context_.seal(block, context)}, stored, raw);
    } catch (const Error& failure) {
      throw Error(failure.code(),
                  fmt::format("read {}: block {} at byte {}: {}", file_.path().native(), block,
                              table_[block].offset, failure.what()));
    }
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  File file_;
  mutable std::mutex mutex_;  ///< guards extents_, and changes of entries against advise()
  ExtentAllocator extents_;
  Filters filters_;
  LevelContext context_;  ///< refers to filters_
  std::shared_ptr<const BlockMaker> maker_;
  std::string why_no_maker_;
  Coding coding_;
  CoderPool& coders_;
  OpenLevels& open_levels_;
};

class CompressedVolume final : public Volume {
 public:
  CompressedVolume(std::shared_ptr<const PipelineRegistry> pipelines, const VolumeSpec& volume)
      : pipelines_(std::move(pipelines)), coders_(*pipelines_, volume) {}

  std::unique_ptr<Backend> open_level(const LevelSpec& level) override {
    const FilterLevel filtered{
        level.schema, &level.geometry, level.table.attribute(), level.table.level(),
        level.surroundings.attributes.empty() ? nullptr : &level.surroundings};
    auto opened = std::make_unique<CompressedBackend>(
        level, pipelines_->make(level.pipeline, filtered), coders_, open_levels_);
    coders_.make_room_for(opened->coding(), level.geometry.max_block_bytes());
    return opened;
  }
  std::uint64_t scratch_bytes() const noexcept override { return coders_.memory_bytes(); }
  void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) override {
    for (CompressedBackend* const level : open_levels_) level->begin_version(sequence, held);
    coders_.shrink();
  }

 private:
  std::shared_ptr<const PipelineRegistry> pipelines_;
  CoderPool coders_;
  OpenLevels open_levels_;
};

}  // namespace

BackendRegistry::Entry compressed_backend(const PipelineRegistry& pipelines) {
  const auto shared = std::make_shared<const PipelineRegistry>(pipelines);
  BackendRegistry::Entry entry;
  entry.name = "compressed";
  entry.summary = "a pipeline of filters and a codec for each block (--compress)";
  entry.traits = kCompressedTraits;
  entry.open = [shared](const VolumeSpec& volume) {
    return std::make_unique<CompressedVolume>(shared, volume);
  };
  entry.default_pipeline = "shuffle,zstd:1";
  entry.interim_pipeline = [](const AttributeSchema& schema) {
    return preset_pipeline("fast", schema);
  };
  entry.validate_pipeline = [shared](std::string_view pipeline, const AttributeSchema& schema) {
    FilterLevel level;
    level.schema = schema;
    shared->make(pipeline, level);
  };
  entry.needs_other_blocks = [shared](std::string_view pipeline, const AttributeSchema& schema) {
    FilterLevel level;
    level.schema = schema;
    return need_other_blocks(shared->make(pipeline, level).filters);
  };
  entry.plan_pipeline = [shared](std::string_view pipeline, const Provenance& provenance,
                                 const AttributeSchema& schema, int finest_level) {
    const BlockMakers* const makers = shared->block_makers();
    const std::string recipe =
        makers ? makers->recipe(provenance, schema, finest_level) : std::string();
    return recipe.empty() ? without_predicted_stage(pipeline) : with_recipe(pipeline, recipe);
  };
  return entry;
}

PLAIT_END_NAMESPACE
