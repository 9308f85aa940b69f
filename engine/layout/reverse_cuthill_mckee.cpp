#include "layout/reverse_cuthill_mckee.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "base/interruption.h"
#include "base/threads.h"

namespace plait::layout {
namespace {

/// [face] the faces across its sides, in the order of the sides. If a border leaves fewer than
/// three, the last entries are kNoId.
using Neighbours = std::vector<std::array<FaceId, 3>>;

Neighbours find_neighbours(const Topology& topology) {
  Neighbours neighbours(topology.faces.size());
  ranges_on_workers(neighbours.size(), 1 << 14, [&](std::size_t first, std::size_t last) {
    for (std::size_t face = first; face < last; ++face) {
      std::size_t degree = 0;
      neighbours[face].fill(kNoId);
      for (int side = 0; side < 3; ++side) {
        const FaceSide beyond = topology.across(FaceSide(static_cast<FaceId>(face), side));
        if (beyond.exists()) neighbours[face][degree++] = beyond.face();
      }
    }
  });
  return neighbours;
}

int degree(const Neighbours& neighbours, FaceId face) {
  int result = 0;
  for (const FaceId next : neighbours[face]) result += next != kNoId ? 1 : 0;
  return result;
}

/// Breadth-first searches. A search costs time in proportion to its component, not to the mesh.
class StartFinder {
 public:
  explicit StartFinder(const Neighbours& neighbours)
      : neighbours_(neighbours), visited_(neighbours.size(), 0) {
    queue_.reserve(neighbours.size());
  }

  bool was_visited(FaceId face) const { return visited_[face] != 0; }

  /// Finds a face at an end of its component: a face whose farthest face is as far away as
  /// possible. A few searches find it approximately. REQUIRES: no search has visited the component.
  FaceId find(FaceId seed) {
    constexpr std::uint8_t kMaxSearches = 8;
    FaceId start = seed;
    std::uint32_t depth = 0;
    for (std::uint8_t search = 1; search <= kMaxSearches; ++search) {
      const std::uint32_t previous_depth = depth;
      const std::span<const FaceId> farthest = last_ring(start, search, &depth);
      if (search > 1 && depth <= previous_depth) break;
      start = *std::min_element(farthest.begin(), farthest.end(), [this](FaceId a, FaceId b) {
        return std::pair(degree(neighbours_, a), a) < std::pair(degree(neighbours_, b), b);
      });
    }
    return start;
  }

 private:
  /// The faces farthest from `start`; valid until the next call.
  std::span<const FaceId> last_ring(FaceId start, std::uint8_t search, std::uint32_t* depth) {
    queue_.assign(1, start);
    visited_[start] = search;
    std::size_t ring_begin = 0;
    for (*depth = 0;; ++*depth) {
      const std::size_t ring_end = queue_.size();
      for (std::size_t i = ring_begin; i < ring_end; ++i) {
        if (is_turn_to_poll(i)) poll_interruption();
        for (const FaceId next : neighbours_[queue_[i]]) {
          if (next == kNoId) break;
          if (visited_[next] == search) continue;
          visited_[next] = search;
          queue_.push_back(next);
        }
      }
      if (queue_.size() == ring_end) return {queue_.data() + ring_begin, ring_end - ring_begin};
      ring_begin = ring_end;
    }
  }

  const Neighbours& neighbours_;
  /// [face] the last search that visited it, 0 for none. Components share no face, so the searches
  /// of each component count from 1.
  std::vector<std::uint8_t> visited_;
  std::vector<FaceId> queue_;
};

}  // namespace

std::vector<FaceId> reverse_cuthill_mckee(const Topology& topology) {
  const auto face_count = static_cast<FaceId>(topology.faces.size());
  const Neighbours neighbours = find_neighbours(topology);
  StartFinder finder(neighbours);
  std::vector<FaceId> order;  // also the queue of the search
  order.reserve(face_count);
  std::vector<std::uint8_t> placed(face_count, 0);
  std::size_t done = 0;
  const auto place = [&](FaceId face) {
    placed[face] = 1;
    order.push_back(face);
  };
  for (FaceId seed = 0; seed < face_count; ++seed) {
    if (finder.was_visited(seed)) continue;
    place(finder.find(seed));
    for (; done < order.size(); ++done) {
      if (is_turn_to_poll(done)) poll_interruption();
      const std::size_t first_new = order.size();
      for (const FaceId next : neighbours[order[done]]) {
        if (next == kNoId || placed[next] != 0) continue;
        place(next);
        // Sorts the new faces by degree and keeps the order of equal ones. There are at most three,
        // so this is an insertion sort.
        for (std::size_t i = order.size() - 1;
             i > first_new && degree(neighbours, order[i]) < degree(neighbours, order[i - 1]); --i)
          std::swap(order[i], order[i - 1]);
      }
    }
  }
  std::ranges::reverse(order);
  return order;
}

}  // namespace plait::layout
