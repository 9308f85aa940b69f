// The slots of one edge, of all levels and outputs, on their way from two patches to their blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/edge_index.h"
#include "plait/store.h"

namespace plait {

/// Where a record of an output lies in a bundle. Records of three floats are held in four: then a
/// patch stores whole vectors, in any order and never over a neighbour.
struct BundleShape {
  struct Output {
    std::uint32_t components = 3;
    std::size_t component_bytes = 4;
    std::size_t record_bytes = 12, stride = 16;  ///< in the store, in the bundle
    std::vector<std::size_t> offsets;            ///< [level] of the slot's first record
  };
  std::vector<Output> outputs;
  int levels = 0;
  std::size_t bytes = 0;

  BundleShape(const Store& store, std::span<const AttributeId> attributes, int finest);
};

/// Bundles are recycled, the last one given back first: it is still in cache. One thread at a time.
class SlotBundles {
 public:
  SlotBundles(std::size_t bundle_bytes, std::uint64_t edge_count)
      : bundle_bytes_(bundle_bytes), bundle_of_(edge_count, nullptr) {}

  /// The edge's bundle, a new one at first. Stays where it is until given back.
  std::byte* of(EdgeId edge);
  void give_back(EdgeId edge);

 private:
  static constexpr std::size_t kSlabBundles = 16;
  struct FreeMemory {
    void operator()(std::byte* memory) const;
  };
  std::size_t bundle_bytes_;
  std::vector<std::byte*> bundle_of_;
  std::vector<std::byte*> vacant_;
  std::vector<std::unique_ptr<std::byte, FreeMemory>> slabs_;
};

}  // namespace plait
