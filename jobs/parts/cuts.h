// Where the edges of a base mesh are cut into parts of equal cost.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "plait/extend/parts.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// What a machine of ten years ago takes; only the ratio of the two matters for the cuts.
inline constexpr double kNsPerByte = 1.3, kNsPerPoint = 5;

/// What a part costs: a record of an edge's slots is written, and read for the digest; a face is
/// refined with all its points, also if it is a ghost.
struct PartCost {
  int levels = 1;  ///< over the base mesh
  double ns_per_record = 0, ns_per_point = 0;

  std::uint64_t records(bool is_border) const;
  std::uint64_t records(const Edge& edge) const { return records(edge.is_border()); }
  double of_edge(bool is_border) const {
    return ns_per_record * static_cast<double>(records(is_border));
  }
  double of_face() const;
};

/// What cuts ask of an edge: for each of its faces, one more than the last of the face's earlier
/// edges; 0 if there is none; kNoId if there is no such face.
struct EarlierEdges {
  EdgeId a = kNoId, b = kNoId;

  void add(EdgeId after) { (a == kNoId ? a : b) = after; }
  bool is_border() const { return b == kNoId; }
};

/// The edges of a base mesh in their order, and the edges of its faces, to be read from front to
/// back as often as one likes: of a mesh in memory, or of a larger one.
class EdgesInOrder {
 public:
  using Faces = std::span<const std::array<EdgeId, 3>>;

  virtual ~EdgesInOrder() = default;
  virtual EdgeId count() const = 0;
  /// Calls `take` with the edges from `first` on, run after run, until it returns false.
  virtual void each_run(
      const std::function<bool(EdgeId first, std::span<const EarlierEdges>)>& take) const = 0;
  virtual void each_face(const std::function<void(Faces)>& take) const = 0;
};

/// What each_run() says, told face by face: take(edge, after). An edge is told once for each of its
/// faces.
template <class Take>
void tell_earlier_edges(EdgesInOrder::Faces faces, const Take& take) {
  for (auto [first, second, third] : faces) {
    if (second < first) std::swap(first, second);
    if (third < second) std::swap(second, third);
    if (second < first) std::swap(first, second);
    take(first, EdgeId{0});
    take(second, first + 1);
    take(third, second + 1);
  }
}

/// Of a mesh in memory, which outlives the object.
class EdgesInMemory final : public EdgesInOrder {
 public:
  explicit EdgesInMemory(const Topology& mesh);
  EdgeId count() const override { return static_cast<EdgeId>(edges_.size()); }
  void each_run(
      const std::function<bool(EdgeId, std::span<const EarlierEdges>)>& take) const override;
  void each_face(const std::function<void(Faces)>& take) const override { take(faces_); }

 private:
  Faces faces_;
  std::vector<EarlierEdges> edges_;
};

/// The first edges of `parts` parts. The most expensive part is as cheap as a cut along the order
/// of the edges allows, to a millionth or five. REQUIRES: 1 <= parts <= edges.
std::vector<EdgeId> cut_edges(const EdgesInOrder& edges, std::uint32_t parts, const PartCost& cost);

/// The figures of each part but its bytes.
std::vector<PlannedPart> figures_of_parts(const EdgesInOrder& edges,
                                          const std::vector<EdgeId>& starts, const PartCost& cost);

PLAIT_END_NAMESPACE
