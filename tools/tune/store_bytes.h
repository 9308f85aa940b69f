// tools/tune/store_bytes.h: reads parts of a store, and divides its levels into blocks of any size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "plait/store.h"

namespace plait::tune {

/// The levels of a store, divided into blocks of another size than they have. Levels consist of the
/// same bytes for every size of blocks.
class BlockGrid {
 public:
  /// The store outlives the grid, which does not move.
  BlockGrid(const Store& store, std::uint64_t block_bytes);
  BlockGrid(const BlockGrid&) = delete;
  BlockGrid& operator=(const BlockGrid&) = delete;

  std::uint64_t block_bytes() const { return block_bytes_; }
  const LevelGeometry& geometry(AttributeId attribute, int level) const {
    return geometries_[attribute][static_cast<std::size_t>(level - first_level_)];
  }
  /// What filters may predict blocks from.
  const LevelSurroundings& surroundings() const { return surroundings_; }
  /// Whether all levels are divided as in `other`.
  bool same_blocks(const BlockGrid& other) const;

 private:
  std::uint64_t block_bytes_;
  int first_level_;
  std::vector<std::vector<LevelGeometry>> geometries_;  ///< [attribute][level - first_level_]
  LevelSurroundings surroundings_;
};

/// Reads ranges of levels, and keeps what it has read, up to a limit. For one thread.
class StoreBytes {
 public:
  /// The store outlives this object.
  StoreBytes(const Store& store, std::uint64_t most_kept_bytes);

  const Store& store() const { return store_; }
  /// Bytes [offset, offset + count) of a level. Valid until the next call of make_room(). Errors:
  /// those of Session::pin.
  std::span<const std::byte> read(AttributeId attribute, int level, std::uint64_t offset,
                                  std::uint64_t count);
  /// Forgets what it has kept, if that is more than the limit.
  void make_room();
  std::uint64_t bytes_read() const { return bytes_read_; }

 private:
  using Key = std::tuple<AttributeId, int, std::uint64_t, std::uint64_t>;

  const Store& store_;
  Session session_;
  std::uint64_t most_kept_bytes_, kept_bytes_ = 0, bytes_read_ = 0;
  std::map<Key, std::vector<std::byte>> kept_;
};

}  // namespace plait::tune
