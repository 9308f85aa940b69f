// Numbers for the vertices of a run of faces: a hash table whose size depends on the run, and not
// on the mesh.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class VertexNumbers {
 public:
  /// Forgets all numbers, and prepares for at most `most` vertices.
  void begin(std::size_t most) {
    entries_.assign(std::bit_ceil(2 * most + 1), {});
    shift_ = 32 - static_cast<int>(std::bit_width(entries_.size() - 1));
  }
  /// The number of a vertex; kNoId before the caller sets it. Valid until the next new vertex.
  std::uint32_t& operator[](VertexId vertex) {
    constexpr std::uint32_t kGolden = 0x9e3779b1;  // 2^32 divided by the golden ratio
    std::size_t at = (vertex * kGolden) >> shift_;
    while (entries_[at].vertex != vertex && entries_[at].vertex != kNoId)
      at = (at + 1) % entries_.size();
    entries_[at].vertex = vertex;
    return entries_[at].number;
  }

 private:
  struct NumberedVertex {
    VertexId vertex = kNoId;
    std::uint32_t number = kNoId;
  };
  std::vector<NumberedVertex> entries_;
  int shift_ = 0;
};

PLAIT_END_NAMESPACE
