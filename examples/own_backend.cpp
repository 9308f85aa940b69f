// A plug-in in C++: the backend x-map, which keeps the blocks of a store in a key-value store. Here
// that is a std::map of this process; a database or an object store has put and get as well.
//
//   plait subdivide mesh.ply --levels 4 --plugin ./own_backend.so --backend x-map --digest
//   plait-conformance --plugin ./own_backend.so --backend x-map
#include <cstdint>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/extend/plugin_in_cpp.h"

namespace {
using plait::BlockRange, plait::Error, plait::ErrorCode, plait::LevelSpec;

// The key-value store. Any number of threads may call it.
class KeyValues {
 public:
  void put(const std::string& key, std::span<const std::byte> value) {
    const std::scoped_lock lock(mutex_);
    values_[key].assign(value.begin(), value.end());
  }
  bool get(const std::string& key, std::span<std::byte> value) const {
    const std::scoped_lock lock(mutex_);
    const auto found = values_.find(key);
    if (found == values_.end() || found->second.size() != value.size()) return false;
    std::memcpy(value.data(), found->second.data(), value.size());
    return true;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<std::byte>> values_;
};

// One level of one attribute. The name of a level is a key, and so is each of its blocks.
class MapBackend final : public plait::Backend {
 public:
  explicit MapBackend(const LevelSpec& level)
      : name_(level.name), geometry_(level.geometry), table_(level.table) {
    if (table_.size() != geometry_.block_count())
      throw Error(ErrorCode::kInvalidArgument, name_ + ": expected an entry for each block");
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check(blocks, into.size());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<std::byte> raw = into.first(geometry_.block_bytes(block));
      into = into.subspan(raw.size());
      if (table_[block].encoding == plait::BlockEncoding::kNeverWritten)
        std::memset(raw.data(), 0, raw.size());
      else if (!values_.get(key_of(block), raw))
        throw Error(ErrorCode::kCorruption, "read " + key_of(block) + ": no value");
      else
        table_.check(block, raw, name_);  // its checksum
    }
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check(blocks, from.size());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block) {
      const std::span<const std::byte> raw = from.first(geometry_.block_bytes(block));
      from = from.subspan(raw.size());
      values_.put(key_of(block), raw);
      table_.seal(block, geometry_.block_offset(block), plait::BlockEncoding::kRaw, raw);
    }
  }

  void advise(BlockRange, plait::Advice) noexcept override {}
  void sync(bool) override {}  // a database would commit here
  std::uint64_t stored_bytes() const override { return geometry_.total_bytes(); }

 private:
  std::string key_of(std::uint64_t block) const { return name_ + '/' + std::to_string(block); }
  void check(BlockRange blocks, std::size_t bytes) const {
    if (blocks.first > table_.size() || blocks.count > table_.size() - blocks.first ||
        bytes != geometry_.range_bytes(blocks.first, blocks.count))
      throw Error(ErrorCode::kInvalidArgument, name_ + ": expected other blocks");
  }

  std::string name_;
  const plait::LevelGeometry& geometry_;
  plait::BlockTable& table_;
  KeyValues values_;
};

}  // namespace

extern "C" PLAIT_PLUGIN_EXPORT std::int32_t plait_plugin_v1(const plait_host* host) {
  return plait::add_in_cpp(host, [](plait::PluginRegistry& registry) {
    const auto open = [](const LevelSpec& level) { return std::make_unique<MapBackend>(level); };
    registry.add(plait::RegisteredBackend{.name = "x-map",
                                          .summary = "keys and values in memory",
                                          .open = plait::open_each_level(open)});
  });
}
