// What one face has of the slots of one of its edges, on its way to the blocks. The two halves of
// an interior edge come from two faces, often long after one another; the first one waits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "plait/edge_index.h"
#include "plait/fused.h"
#include "plait/store.h"

namespace plait {

/// A half holds, output after output and level after level, its records in the order of the slot:
/// of row r the own face has columns 0 to n - 1 - r, the other face the r ones behind. Behind each
/// output there is room for a vector that is stored over the end.
struct HalfShape {
  struct Output {
    std::uint32_t components = 3;
    std::size_t component_bytes = 4, record_bytes = 12;
    std::size_t offset = 0;  ///< of its first record
  };
  std::vector<Output> outputs;
  int levels = 0;
  std::size_t bytes = 0;

  HalfShape(const Store& store, std::span<const AttributeId> attributes, int finest);
};

/// Memory for halves. What was given back last is taken first: it is still in cache. One thread at
/// a time.
class HalfPool {
 public:
  explicit HalfPool(std::size_t half_bytes) : half_bytes_(half_bytes) {}
  std::byte* take();
  void give_back(std::byte* half) { vacant_.push_back(half); }

 private:
  struct Unmap {
    std::size_t bytes;
    void operator()(std::byte* memory) const;
  };
  std::size_t half_bytes_;
  std::vector<std::byte*> vacant_;
  std::vector<std::unique_ptr<std::byte, Unmap>> slabs_;
};

/// Where a group's patches put their halves.
struct GroupHalves {
  struct Side {
    std::array<std::byte*, kPatchLanes> own, other;  ///< [lane]; one of them is `spare`
    bool any_own = false, any_other = false;
  };
  std::array<Side, 3> sides;
};

/// From the lanes of a group of patches to halves. Immutable; safe from any number of threads.
class HalfScatter {
 public:
  HalfScatter(const PatchLattice& lattice, const HalfShape& shape);

  /// `points` is what PatchRefiner::points() gives for this output.
  void operator()(std::size_t output, const void* points, const GroupHalves& to) const;

 private:
  const HalfShape& shape_;
  struct Points {
    std::vector<std::uint32_t> own, other;  ///< of the lattice, in a half's order
  };
  std::array<Points, 3> points_;  ///< [side]
};

/// Puts a slot together: n x n records from the own and the other face's halves, or a border edge's
/// triangle (`other` is null). Pointers are to the first record of the level in each half.
/// `streaming` bypasses the caches: for memory that is not read again soon.
void merge_slot(std::size_t record_bytes, int level, const std::byte* own, const std::byte* other,
                bool streaming, std::byte* slot);
/// Makes streamed slots visible to other threads.
void finish_streaming();

}  // namespace plait
