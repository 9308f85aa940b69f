// position_table.h: finds vertices by their positions.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A hash table with open addressing: a power of two of places, at most half of which are taken. It
/// refers to the positions, and has the numbers of vertices only.
class PositionTable {
 public:
  explicit PositionTable(const std::vector<Vector3<double>>& positions) : positions_(positions) {}

  /// The vertex of the table whose position is `at`; -0 is equal to 0, and coordinates that are no
  /// numbers are equal if their bits are. Without one, `vertex` comes into the table and is the
  /// result; before the next call its position must be `at`.
  VertexId find_or_add(const Vector3<double>& at, VertexId vertex) {
    if (2 * (count_ + 1) > places_.size()) grow();
    const Bits bits = bits_of(at);
    for (std::size_t place = hash(bits) & mask();; place = (place + 1) & mask()) {
      if (places_[place] == kNoId) {
        ++count_;
        return places_[place] = vertex;
      }
      if (bits_of(positions_[places_[place]]) == bits) return places_[place];
    }
  }

 private:
  using Bits = std::array<std::uint64_t, 3>;

  std::size_t mask() const { return places_.size() - 1; }
  static Bits bits_of(const Vector3<double>& at) {
    const auto bits = [](double number) { return std::bit_cast<std::uint64_t>(number + 0.0); };
    return {bits(at.x), bits(at.y), bits(at.z)};
  }
  /// S. Vigna, "splitmix64", 2015: its mixing step.
  static std::size_t hash(const Bits& bits) {
    std::uint64_t value = 0;
    for (const std::uint64_t each : bits) {
      value = (value + each) * 0x9e3779b97f4a7c15u;
      value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    }
    return value ^ (value >> 31);
  }
  void grow() {
    const std::vector<VertexId> before = std::exchange(
        places_, std::vector<VertexId>(std::max<std::size_t>(1024, 2 * places_.size()), kNoId));
    for (const VertexId vertex : before) {
      if (vertex == kNoId) continue;
      std::size_t place = hash(bits_of(positions_[vertex])) & mask();
      while (places_[place] != kNoId) place = (place + 1) & mask();
      places_[place] = vertex;
    }
  }

  const std::vector<Vector3<double>>& positions_;
  std::vector<VertexId> places_;
  std::size_t count_ = 0;
};

PLAIT_END_NAMESPACE
