// bench/peers/slot_store.h: the slots of a refined mesh in what people would take instead of plait:
// files, databases, HDF5. plait_bench_slot_stores measures them. Each function exists only if CMake
// found its library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/layout.h"

namespace plait::bench {

/// Which slot: the records of one edge, one level and one attribute.
struct SlotKey {
  std::uint32_t attribute = 0, level = 1, edge = 0;
  /// Ascends as slots are loaded: by attribute, then level, then edge.
  std::uint64_t number() const {
    return std::uint64_t{attribute * 32 + level} << 32 | std::uint64_t{edge};
  }
};

/// Attributes of float32 x 3 at levels 1 to `levels` of a closed mesh.
struct SlotSizes {
  std::uint32_t attributes = 2, levels = 0, edges = 0;
  static std::size_t bytes(std::uint32_t level) { return sizeof(float) * 3 << (2 * (level - 1)); }
  /// Of all slots with smaller numbers, if they follow one another.
  std::uint64_t offset(const SlotKey& key) const;
  template <class Visit>
  void for_each(Visit visit) const {
    SlotKey key;
    for (key.attribute = 0; key.attribute < attributes; ++key.attribute)
      for (key.level = 1; key.level <= levels; ++key.level)
        for (key.edge = 0; key.edge < edges; ++key.edge) visit(key);
  }
};

using FillSlot = std::function<void(const SlotKey&, std::span<std::byte>)>;

/// For one thread.
class SlotStore {
 public:
  virtual ~SlotStore() = default;
  /// Stores all slots of a new store, durably, as fast as the engine does.
  virtual void load(const FillSlot& fill) = 0;
  /// Reads the slots of the edges of a face, one after another; plait, the records of its patch.
  virtual void read(FaceId face, std::span<const SlotKey> keys, std::span<std::byte> into) = 0;
  /// Replaces slots in one durable step.
  virtual void change(std::span<const SlotKey> keys, const FillSlot& fill) = 0;
};

struct SlotPlace {
  const LaidOutMesh& base;
  SlotSizes sizes;
  std::filesystem::path directory;  ///< exists; the store is in it, if it has been loaded
  std::uint64_t cache_bytes = 0;    ///< that the engine may use itself
};

/// An engine that has slots. open() opens the store of a place or makes a new one.
struct SlotEngine {
  std::string name;
  std::function<std::unique_ptr<SlotStore>(const SlotPlace&)> open;
};

SlotEngine plain_slots();
SlotEngine plait_slots(const std::string& backend);
SlotEngine lmdb_slots();
SlotEngine rocksdb_slots();
SlotEngine sqlite_slots();
SlotEngine hdf5_slots();

/// Throws an error of the engine.
[[noreturn]] inline void refuse(const std::string& engine, const std::string& why) {
  throw Error(ErrorCode::kIo, engine + ": " + why);
}

}  // namespace plait::bench
