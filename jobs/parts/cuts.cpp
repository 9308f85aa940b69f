#include "parts/cuts.h"

#include <algorithm>
#include <queue>

#include "base/interruption.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class EdgeCosts {
 public:
  explicit EdgeCosts(const PartCost& cost)
      : of_inner_(cost.of_edge(false)), of_border_(cost.of_edge(true)), of_face_(cost.of_face()) {}

  /// The faces that refining the edge adds to a part that begins with `first`: those of its faces
  /// that have no other edge in the part yet.
  static std::uint32_t new_faces(EdgeId first, const EarlierEdges& edge) {
    return (edge.a <= first ? 1u : 0u) + (edge.b <= first ? 1u : 0u);
  }
  double cost_of(EdgeId first, const EarlierEdges& edge) const {
    return (edge.is_border() ? of_border_ : of_inner_) + new_faces(first, edge) * of_face_;
  }

 private:
  double of_inner_, of_border_, of_face_;
};

double cost_of_all(const EdgesInOrder& edges, const EdgeCosts& costs) {
  double sum = 0;
  edges.each_run([&](EdgeId, std::span<const EarlierEdges> run) {
    for (const EarlierEdges& edge : run) sum += costs.cost_of(0, edge);
    return true;
  });
  return sum;
}

/// Cuts whenever a part would cost more than `most`. Stops when there are more than `parts`.
std::vector<EdgeId> cut_at(const EdgesInOrder& edges, const EdgeCosts& costs, std::uint32_t parts,
                           double most) {
  std::vector<EdgeId> starts = {0};
  double sum = 0;
  edges.each_run([&](EdgeId edge, std::span<const EarlierEdges> run) {
    EdgeId start = starts.back();
    for (const EarlierEdges& of_edge : run) {
      if (is_turn_to_poll(edge)) poll_interruption();
      const double with = sum + costs.cost_of(start, of_edge);
      if (with <= most || edge == start) {
        sum = with;
      } else {
        starts.push_back(start = edge);
        if (starts.size() > parts) return false;
        sum = costs.cost_of(edge, of_edge);
      }
      ++edge;
    }
    return true;
  });
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

std::uint64_t PartCost::records(bool is_border) const {
  std::uint64_t records = 0;
  for (int level = 1; level <= levels; ++level)
    records += slot_records(level, is_border ? SlotShape::kHalf : SlotShape::kWhole);
  return records;
}

double PartCost::of_face() const {
  const double side = static_cast<double>(std::uint64_t{1} << levels);
  return ns_per_point * (side + 1) * (side + 2) / 2;
}

EdgesInMemory::EdgesInMemory(const Topology& mesh)
    : faces_(mesh.face_edges), edges_(mesh.edges.size()) {
  std::uint64_t told = 0;
  tell_earlier_edges(faces_, [&](EdgeId edge, EdgeId after) {
    if (is_turn_to_poll(++told)) poll_interruption();
    edges_[edge].add(after);
  });
}

void EdgesInMemory::each_run(
    const std::function<bool(EdgeId, std::span<const EarlierEdges>)>& take) const {
  (void)take(0, edges_);
}

std::vector<EdgeId> cut_edges(const EdgesInOrder& edges, std::uint32_t parts,
                              const PartCost& cost) {
  const EdgeCosts costs(cost);
  const auto is_enough = [&](double most) {
    return cut_at(edges, costs, parts, most).size() <= parts;
  };
  // The smallest limit that needs no more parts: a greedy cut is the best one for each limit. It is
  // little above the mean, so steps from there come to it soonest.
  const double all = cost_of_all(edges, costs);
  double too_small = all / parts * (1 - 1e-9), most = too_small;
  for (double step = all / parts / 64; most < all && !is_enough(most = std::min(all, most + step));
       step *= 2)
    too_small = most;
  for (int step = 0; step < 40 && most - too_small > 5e-6 * most; ++step) {
    const double middle = (most + too_small) / 2;
    (is_enough(middle) ? most : too_small) = middle;
  }
  return cut_longest(cut_at(edges, costs, parts, most), parts, edges.count());
}

std::vector<PlannedPart> figures_of_parts(const EdgesInOrder& edges,
                                          const std::vector<EdgeId>& starts, const PartCost& cost) {
  std::vector<PlannedPart> parts(starts.size());
  for (std::size_t at = 0; at < starts.size(); ++at) {
    parts[at].first_edge = starts[at];
    parts[at].edge_after = at + 1 < starts.size() ? starts[at + 1] : edges.count();
  }
  const std::uint64_t of_inner = cost.records(false), of_border = cost.records(true);
  std::size_t part = 0;
  edges.each_run([&](EdgeId edge, std::span<const EarlierEdges> run) {
    for (const EarlierEdges& of_edge : run) {
      if (is_turn_to_poll(edge)) poll_interruption();
      while (edge >= parts[part].edge_after) ++part;
      parts[part].records += of_edge.is_border() ? of_border : of_inner;
      parts[part].faces += EdgeCosts::new_faces(starts[part], of_edge);
      ++edge;
    }
    return true;
  });
  // A face belongs to the part of its lowest edge. It is a ghost in every other one.
  std::vector<std::uint64_t> own(starts.size());
  edges.each_face([&](EdgesInOrder::Faces faces) {
    std::size_t last = 0;  // mostly that of the face before
    for (const auto& [a, b, c] : faces) {
      const EdgeId lowest = std::min({a, b, c});
      if (lowest < parts[last].first_edge || lowest >= parts[last].edge_after)
        last =
            static_cast<std::size_t>(std::ranges::upper_bound(starts, lowest) - starts.begin()) - 1;
      ++own[last];
    }
  });
  for (std::size_t at = 0; at < parts.size(); ++at) {
    parts[at].seconds = 1e-9 * (cost.ns_per_record * static_cast<double>(parts[at].records) +
                                cost.of_face() * static_cast<double>(parts[at].faces));
    parts[at].ghosts = parts[at].faces - own[at];
  }
  return parts;
}

PLAIT_END_NAMESPACE
