#include "parts/cuts.h"

#include <algorithm>
#include <queue>

#include "base/interruption.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The costs of all edges, in one array that is read from front to back, again and again.
class EdgeCosts {
 public:
  EdgeCosts(const Topology& mesh, const PartCost& cost) : of_face_(cost.of_face()) {
    edges_.reserve(mesh.edges.size());
    for (EdgeId edge = 0; edge < mesh.edges.size(); ++edge) {
      if (is_turn_to_poll(edge)) poll_interruption();
      const auto after_earlier = [&](FaceSide side) {
        if (!side.exists()) return kNoId;
        EdgeId after = 0;
        for (const EdgeId other : mesh.face_edges[side.face()])
          if (other < edge) after = std::max(after, other + 1);
        return after;
      };
      const Edge& of_mesh = mesh.edges[edge];
      edges_.push_back({after_earlier(of_mesh.own), after_earlier(of_mesh.other)});
      (of_mesh.is_border() ? of_border_ : of_inner_) = cost.of_edge(of_mesh);
    }
  }

  EdgeId size() const { return static_cast<EdgeId>(edges_.size()); }

  /// The faces that refining edge `edge` adds to a part that begins with `first`: those of its
  /// faces that have no other edge in the part yet.
  std::uint32_t new_faces(EdgeId first, EdgeId edge) const {
    const auto& [own, other] = edges_[edge];
    return (own <= first ? 1u : 0u) + (other <= first ? 1u : 0u);
  }

  double cost_of(EdgeId first, EdgeId edge) const {
    return (edges_[edge].other == kNoId ? of_border_ : of_inner_) +
           new_faces(first, edge) * of_face_;
  }

 private:
  /// For each of its faces, one more than the last of the face's earlier edges; 0 if there is none;
  /// kNoId if there is no such face.
  struct AfterEarlier {
    EdgeId own, other;
  };
  std::vector<AfterEarlier> edges_;
  double of_inner_ = 0, of_border_ = 0, of_face_;
};

/// Cuts whenever a part would cost more than `most`. Stops when there are more than `parts`.
std::vector<EdgeId> cut_at(const EdgeCosts& costs, std::uint32_t parts, double most) {
  std::vector<EdgeId> starts = {0};
  double sum = 0;
  for (EdgeId edge = 0; edge < costs.size() && starts.size() <= parts; ++edge) {
    if (is_turn_to_poll(edge)) poll_interruption();
    const double with = sum + costs.cost_of(starts.back(), edge);
    if (with <= most || edge == starts.back()) {
      sum = with;
      continue;
    }
    starts.push_back(edge);
    sum = costs.cost_of(edge, edge);
  }
  return starts;
}

/// Halves the longest part again and again until there are `parts`; of parts of one length the
/// first.
std::vector<EdgeId> cut_longest(std::vector<EdgeId> starts, std::uint32_t parts, EdgeId edges) {
  struct Range {
    EdgeId length, first;
    bool operator<(const Range& other) const {  // the longest comes first from a queue
      return length != other.length ? length < other.length : first > other.first;
    }
  };
  std::priority_queue<Range> ranges;
  for (std::size_t part = 0; part < starts.size(); ++part)
    ranges.push(
        {(part + 1 < starts.size() ? starts[part + 1] : edges) - starts[part], starts[part]});
  while (starts.size() < parts) {
    const Range longest = ranges.top();
    ranges.pop();
    const EdgeId half = longest.length / 2;
    ranges.push({half, longest.first});
    ranges.push({longest.length - half, longest.first + half});
    starts.push_back(longest.first + half);
  }
  std::ranges::sort(starts);
  return starts;
}

}  // namespace

std::uint64_t PartCost::records(const Edge& edge) const {
  std::uint64_t records = 0;
  for (int level = 1; level <= levels; ++level)
    records += slot_records(level, edge.is_border() ? SlotShape::kHalf : SlotShape::kWhole);
  return records;
}

double PartCost::of_face() const {
  const double side = static_cast<double>(std::uint64_t{1} << levels);
  return ns_per_point * (side + 1) * (side + 2) / 2;
}

std::vector<EdgeId> cut_edges(const Topology& mesh, std::uint32_t parts, const PartCost& cost) {
  const EdgeCosts costs(mesh, cost);
  double most = 0;
  for (EdgeId edge = 0; edge < costs.size(); ++edge) most += costs.cost_of(0, edge);
  // The smallest limit that needs no more parts: a greedy cut is the best one for each limit.
  double too_small = 0;
  for (int step = 0; step < 40 && most - too_small > 1e-6 * most; ++step) {
    const double middle = (most + too_small) / 2;
    (cut_at(costs, parts, middle).size() <= parts ? most : too_small) = middle;
  }
  return cut_longest(cut_at(costs, parts, most), parts, costs.size());
}

std::vector<PlannedPart> figures_of_parts(const Topology& mesh, const std::vector<EdgeId>& starts,
                                          const PartCost& cost) {
  const EdgeCosts costs(mesh, cost);
  std::vector<PlannedPart> parts;
  for (std::size_t at = 0; at < starts.size(); ++at) {
    PlannedPart& part = parts.emplace_back();
    part.first_edge = starts[at];
    part.edge_after =
        at + 1 < starts.size() ? starts[at + 1] : static_cast<EdgeId>(mesh.edges.size());
    for (EdgeId edge = part.first_edge; edge < part.edge_after; ++edge) {
      if (is_turn_to_poll(edge)) poll_interruption();
      part.records += cost.records(mesh.edges[edge]);
      part.faces += costs.new_faces(part.first_edge, edge);
    }
    part.seconds = 1e-9 * (cost.ns_per_record * static_cast<double>(part.records) +
                           cost.of_face() * static_cast<double>(part.faces));
  }
  // A face belongs to the part of its lowest edge. It is a ghost in every other one.
  std::vector<std::uint64_t> own(starts.size());
  for (const auto& edges : mesh.face_edges) {
    const auto after = std::ranges::upper_bound(starts, *std::ranges::min_element(edges));
    ++own[static_cast<std::size_t>(after - starts.begin()) - 1];
  }
  for (std::size_t at = 0; at < parts.size(); ++at) parts[at].ghosts = parts[at].faces - own[at];
  return parts;
}

PLAIT_END_NAMESPACE
