#include "parts/base_in_ranges.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "base/interruption.h"
#include "format/file_names.h"
#include "layout/base_directory.h"
#include "mesh/weld.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Entries that are in memory at once.
constexpr std::uint64_t kRun = std::uint64_t{1} << 16;

struct EarlierEdge {
  EdgeId edge, after;
  bool operator<(const EarlierEdge& other) const {
    return std::tie(edge, after) < std::tie(other.edge, other.after);
  }
};

/// An edge at one of its vertices.
struct EdgeEnd {
  VertexId at, other;
  bool operator<(const EdgeEnd& next) const {
    return std::tie(at, other) < std::tie(next.at, next.other);
  }
};

/// The same, with the position of the other vertex.
struct PlacedEnd {
  VertexId at, other;
  std::array<double, 3> position;
  bool operator<(const PlacedEnd& next) const {
    return std::tie(at, other) < std::tie(next.at, next.other);
  }
};

struct LengthAtVertex {
  double length;
  VertexId at;
  bool operator<(const LengthAtVertex& next) const {
    return std::tie(at, length) < std::tie(next.at, next.length);
  }
};

/// A vertex by its position in float32.
struct NarrowVertex {
  std::array<float, 3> narrow;
  VertexId vertex;
  std::array<double, 3> exact;
  bool operator<(const NarrowVertex& next) const {
    return std::tie(narrow, vertex) < std::tie(next.narrow, next.vertex);
  }
};

Vector3<double> vector_of(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

/// The records of a sort, of which those of each vertex are taken in turn.
template <class Record>
class OfVertices {
 public:
  explicit OfVertices(ExternalSort<Record>& sort) : sort_(sort) { more_ = sort_.next(next_); }

  /// Vertices ascend from call to call.
  template <class Take>
  void each(VertexId vertex, const Take& take) {
    for (; more_ && next_.at == vertex; more_ = sort_.next(next_)) take(next_);
  }

 private:
  ExternalSort<Record>& sort_;
  Record next_{};
  bool more_ = false;
};

void put_earlier_edges(const EdgesInOrder& edges, ExternalSort<EarlierEdge>& earlier,
                       RecordFile<EarlierEdges>& to) {
  edges.each_face([&](EdgesInOrder::Faces faces) {
    tell_earlier_edges(faces, [&](EdgeId edge, EdgeId after) { earlier.push({edge, after}); });
  });
  earlier.sort();
  EarlierEdge next{};
  bool more = earlier.next(next);
  for (EdgeId edge = 0; edge < edges.count(); ++edge) {
    EarlierEdges of_edge;
    for (; more && next.edge == edge; more = earlier.next(next)) of_edge.add(next.after);
    to.put(of_edge);
  }
}

}  // namespace

BaseInRanges::BaseInRanges(const std::filesystem::path& base,
                           const std::filesystem::path& final_path, std::uint64_t memory_bytes)
    : pages_(open_base_pages(base)),
      mesh_(BaseMesh::of(pages_)),
      scratch_(final_path, "partial", MadeProof::kMark,
               [](const Directory& directory) { directory.remove_if_possible(kTemporaryName); }) {
  sort_memory_.bytes = memory_bytes / 2;
}

std::uint64_t BaseInRanges::whole_bytes(const std::filesystem::path& base) {
  // A plan of the whole mesh has costs of edges and lengths around vertices beside the arrays.
  return File(Directory(base), kBaseIndexName, OpenMode::kRead).size() / 4 * 5;
}

BaseCounts BaseInRanges::counts(const std::filesystem::path& base) {
  const auto pages = open_base_pages(base);
  const MeshArrays& arrays = pages->arrays();
  return {arrays.positions.size(), arrays.mesh.edges.size(), arrays.mesh.faces.size(),
          arrays.mesh.border_edges.size()};
}

std::uint64_t BaseInRanges::disk_of_narrowing(const BaseCounts& counts,
                                              std::uint64_t memory_bytes) {
  const auto of_sort = [&](std::uint64_t records, std::size_t record_bytes) {
    return disk_of_sort(records, record_bytes, {memory_bytes / 2});
  };
  const std::uint64_t ends = of_sort(counts.edges, sizeof(EdgeEnd)),
                      placed = of_sort(counts.edges, sizeof(PlacedEnd)),
                      lengths = of_sort(2 * counts.edges, sizeof(LengthAtVertex)),
                      merged = of_sort(counts.vertices, sizeof(NarrowVertex));
  return std::max({ends + placed, placed + lengths, merged});
}

std::uint64_t BaseInRanges::disk_of_edges(const BaseCounts& counts, std::uint64_t memory_bytes) {
  return disk_of_sort(3 * counts.faces, sizeof(EarlierEdge), {memory_bytes / 2}) +
         counts.edges * sizeof(EarlierEdges);
}

/// take(first, after): entries [first, after) of the array can be read.
template <class Take>
void BaseInRanges::each_run(MeshArray array, std::uint64_t count, const Take& take) const {
  for (std::uint64_t first = 0; first < count; first += kRun) {
    poll_interruption();
    const std::uint64_t after = std::min(count, first + kRun);
    pages_->need_range(array, first, after);
    take(first, after);
    pages_->forget(array, first, after);
  }
}

std::uint64_t BaseInRanges::seam_vertices() const {
  const std::span<const EdgeId> border = mesh_.border_edges();
  const MeshArrays& arrays = pages_->arrays();
  std::vector<VertexId> vertices;
  for (std::size_t at = 0; at < border.size();) {
    const EdgeId first = border[at];
    std::size_t after = at;
    while (after < border.size() && border[after] - first < kRun) ++after;
    const std::span<const EdgeId> run = border.subspan(at, after - at);
    pages_->need_elements(MeshArray::kEdges, run);
    for (const EdgeId edge : run)
      vertices.insert(vertices.end(), {arrays.mesh.edges[edge].start, arrays.mesh.edges[edge].end});
    pages_->forget(MeshArray::kEdges, first, std::uint64_t{border[after - 1]} + 1);
    at = after;
  }
  std::ranges::sort(vertices);
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Vector3<double>> positions;
  positions.reserve(vertices.size());
  std::uint64_t kept = 0;
  for (const VertexId vertex : vertices) {
    pages_->need_elements(MeshArray::kPositions, std::span(&vertex, 1));
    positions.push_back(arrays.positions[vertex]);
    if (vertex < kept + kRun && positions.size() < vertices.size()) continue;
    pages_->forget(MeshArray::kPositions, kept, std::uint64_t{vertex} + 1);
    kept = vertex;
  }
  std::iota(vertices.begin(), vertices.end(), VertexId{0});
  return coinciding_vertices(positions, vertices);
}

Narrowing BaseInRanges::narrowing(int levels) {
  Narrowing result;
  result.levels = levels;
  const MeshArrays& arrays = pages_->arrays();
  auto ends = sort<EdgeEnd>();
  each_run(MeshArray::kEdges, mesh_.edge_count(), [&](std::uint64_t first, std::uint64_t after) {
    for (std::uint64_t edge = first; edge < after; ++edge)
      ends->push({arrays.mesh.edges[edge].start, arrays.mesh.edges[edge].end});
  });
  const auto each_vertex = [&](const auto& take) {
    each_run(MeshArray::kPositions, mesh_.vertex_count(),
             [&](std::uint64_t first, std::uint64_t after) {
               for (std::uint64_t vertex = first; vertex < after; ++vertex)
                 take(static_cast<VertexId>(vertex), arrays.positions[vertex]);
             });
  };
  ends->sort();
  auto placed = sort<PlacedEnd>();
  OfVertices<EdgeEnd> starts(*ends);
  each_vertex([&](VertexId vertex, const Vector3<double>& p) {
    starts.each(vertex, [&](const EdgeEnd& end) {
      placed->push({end.other, end.at, {p.x, p.y, p.z}});
    });
  });
  ends.reset();
  placed->sort();
  auto lengths = sort<LengthAtVertex>();
  OfVertices<PlacedEnd> others(*placed);
  each_vertex([&](VertexId vertex, const Vector3<double>& p) {
    others.each(vertex, [&](const PlacedEnd& end) {
      const double length = edge_length(vector_of(end.position), p);
      lengths->push({length, end.at});
      lengths->push({length, end.other});
    });
  });
  placed.reset();
  lengths->sort();
  OfVertices<LengthAtVertex> around(*lengths);
  bool fit = true;
  each_vertex([&](VertexId vertex, const Vector3<double>& p) {
    EdgesOfVertex edges;
    around.each(vertex, [&](const LengthAtVertex& length) { edges.add(length.length); });
    add_vertex(p, edges, result);
    fit = fit && float32_position(p) == p;
  });
  lengths.reset();
  if (!fit) add_merged(result);
  return result;
}

void BaseInRanges::add_merged(Narrowing& result) {
  const MeshArrays& arrays = pages_->arrays();
  auto vertices = sort<NarrowVertex>();
  each_run(MeshArray::kPositions, mesh_.vertex_count(),
           [&](std::uint64_t first, std::uint64_t after) {
             for (std::uint64_t vertex = first; vertex < after; ++vertex) {
               const Vector3<double>& p = arrays.positions[vertex];
               const Vector3<double> narrow = float32_position(p);
               if (!is_finite_position(narrow)) continue;
               const auto number = [](double coordinate) {
                 return static_cast<float>(coordinate + 0.0);  // -0 becomes 0
               };
               vertices->push({{number(narrow.x), number(narrow.y), number(narrow.z)},
                               static_cast<VertexId>(vertex),
                               {p.x, p.y, p.z}});
             }
           });
  vertices->sort();
  NarrowVertex next{}, first{};
  for (bool is_any = false; vertices->next(next); is_any = true)
    if (!is_any || next.narrow != first.narrow)
      first = next;
    else if (next.exact != first.exact)
      ++result.merged;
}

class BaseInRanges::Edges final : public EdgesInOrder {
 public:
  explicit Edges(BaseInRanges& base) : base_(base), edges_(base.scratch_.directory()) {
    put_earlier_edges(*this, *base.sort<EarlierEdge>(), edges_);
  }

  EdgeId count() const override { return static_cast<EdgeId>(base_.mesh_.edge_count()); }

  void each_run(
      const std::function<bool(EdgeId, std::span<const EarlierEdges>)>& take) const override {
    SequentialReader<EarlierEdges> reader = edges_.read();
    std::vector<EarlierEdges> run;
    EdgeId first = 0;
    for (EarlierEdges next; reader.next(next);) {
      run.push_back(next);
      if (run.size() < kRun) continue;
      if (!take(first, run)) return;
      first += static_cast<EdgeId>(run.size());
      run.clear();
    }
    if (!run.empty()) (void)take(first, run);
  }

  void each_face(const std::function<void(Faces)>& take) const override {
    base_.each_run(MeshArray::kFaceEdges, base_.mesh_.face_count(),
                   [&](std::uint64_t first, std::uint64_t after) {
                     take(base_.pages_->arrays().mesh.face_edges.subspan(first, after - first));
                   });
  }

 private:
  BaseInRanges& base_;
  mutable RecordFile<EarlierEdges> edges_;  ///< reading writes out what its buffer has
};

std::unique_ptr<EdgesInOrder> BaseInRanges::edges() { return std::make_unique<Edges>(*this); }

PLAIT_END_NAMESPACE
