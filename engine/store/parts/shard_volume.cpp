#include "store/parts/shard_volume.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/parts/shard_place.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class ShardLevel final : public Backend {
 public:
  /// The volume outlives this object.
  ShardLevel(const LevelSpec& level, ShardVolume& volume) : level_(level), volume_(volume) {}
  ~ShardLevel() override { volume_.close_files_of(*this); }
  ShardLevel(const ShardLevel&) = delete;
  ShardLevel& operator=(const ShardLevel&) = delete;

  std::shared_ptr<OpenShard> open_shard(std::uint32_t shard) const {
    auto opened = std::make_shared<OpenShard>();
    opened->level = this;
    opened->shard = shard;
    opened->geometry = level_.geometry.shard(shard);
    opened->table =
        level_.table.part(level_.geometry.first_block(shard), opened->geometry.block_count());
    LevelSpec spec{
        level_.directory, {}, OpenMode::kRead, opened->geometry, opened->table, level_.schema,
        level_.pipeline};
    place_of(shard, opened->geometry).put_into(spec);
    spec.surroundings = level_.surroundings;
    opened->backend = volume_.inner_->open_level(spec);
    return opened;
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    const LevelGeometry& geometry = level_.geometry;
    const std::uint64_t end = blocks.first + blocks.count;
    if (end < blocks.first || end > geometry.block_count() ||
        into.size() != geometry.range_bytes(blocks.first, blocks.count))
      throw Error(ErrorCode::kInvalidArgument, "access blocks of a level: expected its own");
    for (std::uint64_t block = blocks.first; block < end;) {
      const std::uint32_t shard = geometry.shard_of_block(block);
      const std::uint64_t count = std::min(end, geometry.first_block(shard + 1)) - block;
      const std::uint64_t bytes = geometry.range_bytes(block, count);
      const std::shared_ptr<OpenShard> opened = volume_.open(*this, shard);
      opened->backend->read({block - geometry.first_block(shard), count}, into.first(bytes));
      into = into.subspan(bytes);
      block += count;
    }
  }
  void write(BlockRange, std::span<const std::byte>) override { refuse_writing(); }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override { refuse_writing(); }

  std::uint64_t stored_bytes() const override {
    std::uint64_t bytes = 0;
    for (std::uint32_t shard = 0; shard < level_.geometry.shards().size(); ++shard)
      bytes += stored_bytes_of(shard);
    return bytes;
  }

 private:
  std::uint64_t stored_bytes_of(std::uint32_t shard) const {
    if (!volume_.shares_files_)
      return File(level_.directory, place_of(shard, level_.geometry).name, OpenMode::kRead).size();
    // Without opening the files, of which there may be thousands.
    if (volume_.traits_.overwrites_in_place)
      return bytes_in_shared_file(level_.geometry.shard(shard));
    return open_shard(shard)->backend->stored_bytes();
  }
  ShardPlace place_of(std::uint32_t shard, const LevelGeometry& alone) const {
    return plait::place_of(
        {level_.table.attribute(), level_.table.level(), level_.table.generation(), shard, alone},
        volume_.shares_files_, volume_.traits_);
  }
  [[noreturn]] void refuse_writing() const {
    throw Error(ErrorCode::kBadState, "write " + level_.path().native() + ": it is in shards");
  }

  LevelSpec level_;
  ShardVolume& volume_;
};

ShardVolume::ShardVolume(std::unique_ptr<Volume> inner, bool shares_files,
                         const BackendTraits& traits)
    : inner_(std::move(inner)), shares_files_(shares_files), traits_(traits) {}
ShardVolume::~ShardVolume() = default;

std::unique_ptr<Backend> ShardVolume::open_level(const LevelSpec& level) {
  if (level.geometry.shards().empty()) return inner_->open_level(level);
  auto opened = std::make_unique<ShardLevel>(level, *this);
  // The inner volume takes its scratch memory when it first opens a level with the largest blocks.
  const EdgeShards& shards = level.geometry.shards();
  std::uint32_t largest = 0;
  for (std::uint32_t shard = 1; shard < shards.size(); ++shard)
    if (shards.edge_after(shard) - shards.first_edge(shard) >
        shards.edge_after(largest) - shards.first_edge(largest))
      largest = shard;
  opened->open_shard(largest);
  return opened;
}

std::shared_ptr<OpenShard> ShardVolume::open(const ShardLevel& level, std::uint32_t shard) {
  const std::scoped_lock lock(mutex_);
  const auto found = std::ranges::find_if(open_, [&](const std::shared_ptr<OpenShard>& file) {
    return file->level == &level && file->shard == shard;
  });
  if (found != open_.end()) {
    open_.splice(open_.begin(), open_, found);
    return open_.front();
  }
  if (open_.size() >= kMostOpenFiles) open_.pop_back();
  open_.push_front(level.open_shard(shard));
  return open_.front();
}

void ShardVolume::close_files_of(const ShardLevel& level) noexcept {
  const std::scoped_lock lock(mutex_);
  open_.remove_if([&](const std::shared_ptr<OpenShard>& file) { return file->level == &level; });
}

PLAIT_END_NAMESPACE
