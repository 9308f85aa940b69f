#include "layout/reverse_cuthill_mckee.h"

#include <algorithm>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <boost/property_map/property_map.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>

namespace plait::layout {
namespace {

using DualGraph =
    boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                       boost::no_property, FaceId, std::uint32_t>;

DualGraph dual_graph(const Topology& topology) {
  std::vector<std::pair<FaceId, FaceId>> links;
  links.reserve(3 * topology.faces.size());
  for (FaceId face = 0; face < topology.faces.size(); ++face) {
    for (int side = 0; side < 3; ++side) {
      const FaceSide beyond = topology.across(FaceSide(face, side));
      if (beyond.exists()) links.emplace_back(face, beyond.face());
    }
  }
  return {boost::edges_are_sorted, links.begin(), links.end(),
          static_cast<FaceId>(topology.faces.size())};
}

/// Breadth-first searches that cost no more than the component they are in. Boost's own search for
/// a starting vertex clears a map of the whole graph each time, which is quadratic for a mesh of
/// many small components.
class StartFinder {
 public:
  explicit StartFinder(const DualGraph& graph)
      : graph_(graph), visited_(boost::num_vertices(graph), 0) {}

  bool was_visited(FaceId face) const { return visited_[face] != 0; }

  /// A face whose distance to the farthest one is, as far as a few searches can tell, the largest
  /// in its component.
  FaceId find(FaceId seed) {
    constexpr int kMaxSearches = 8;
    FaceId start = seed;
    std::uint32_t depth = 0;
    for (int search = 0; search < kMaxSearches; ++search) {
      const std::uint32_t previous_depth = depth;
      const std::span<const FaceId> farthest = last_ring(start, &depth);
      if (search > 0 && depth <= previous_depth) break;
      start = *std::min_element(farthest.begin(), farthest.end(), [this](FaceId a, FaceId b) {
        return std::pair(boost::out_degree(a, graph_), a) <
               std::pair(boost::out_degree(b, graph_), b);
      });
    }
    return start;
  }

 private:
  /// The faces farthest from `start`; valid until the next call.
  std::span<const FaceId> last_ring(FaceId start, std::uint32_t* depth) {
    ++search_number_;
    queue_.assign(1, start);
    visited_[start] = search_number_;
    std::size_t ring_begin = 0;
    for (*depth = 0;; ++*depth) {
      const std::size_t ring_end = queue_.size();
      for (std::size_t i = ring_begin; i < ring_end; ++i) {
        const auto [first, last] = boost::out_edges(queue_[i], graph_);
        for (auto link = first; link != last; ++link) {
          const FaceId next = boost::target(*link, graph_);
          if (visited_[next] == search_number_) continue;
          visited_[next] = search_number_;
          queue_.push_back(next);
        }
      }
      if (queue_.size() == ring_end) return {queue_.data() + ring_begin, ring_end - ring_begin};
      ring_begin = ring_end;
    }
  }

  const DualGraph& graph_;
  std::vector<std::uint64_t> visited_;  ///< number of the last search that came by; 0 for none
  std::vector<FaceId> queue_;
  std::uint64_t search_number_ = 0;
};

}  // namespace

std::vector<FaceId> reverse_cuthill_mckee(const Topology& topology) {
  const auto face_count = static_cast<FaceId>(topology.faces.size());
  if (face_count == 0) return {};
  const DualGraph graph = dual_graph(topology);

  std::deque<FaceId> starts;
  {
    StartFinder finder(graph);
    for (FaceId face = 0; face < face_count; ++face)
      if (!finder.was_visited(face)) starts.push_back(finder.find(face));
  }

  std::vector<FaceId> order(face_count);
  std::vector<boost::default_color_type> colors(face_count);
  const auto index = boost::get(boost::vertex_index, graph);
  boost::cuthill_mckee_ordering(graph, starts, order.rbegin(),
                                boost::make_iterator_property_map(colors.begin(), index),
                                boost::make_out_degree_map(graph));
  return order;
}

}  // namespace plait::layout
