// The faces at one vertex, from its corners alone: which sides meet, and which corner is the first.
// The same answers as match_sides() and find_vertex_corners() (engine/mesh/connectivity.h) give for
// a whole mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A corner with the vertices of its face's other two corners.
struct CornerAtVertex {
  VertexId vertex;
  std::uint32_t code;  ///< FaceSide
  VertexId next, before;
  friend bool operator<(const CornerAtVertex& a, const CornerAtVertex& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.code < b.code;
  }
};

class VertexFan {
 public:
  /// `source` begins messages.
  explicit VertexFan(std::string source) : source_(std::move(source)) {}

  /// `corners` are all of one vertex, ascending. Errors: kInvalidArgument as match_sides() has
  /// them.
  void find(std::span<const CornerAtVertex> corners);

  /// [corner] the other side of the edge to the next corner, or kNoId.
  std::span<const std::uint32_t> twins() const { return twins_; }
  /// The corner at which sums around the vertex start.
  std::size_t first_corner() const { return first_; }
  bool is_on_border() const { return is_on_border_; }

  /// Of all vertices until now.
  std::uint64_t border_edges() const { return border_edges_; }
  /// Throws the first error that another one of a later vertex precedes. Errors: kNotSupported for
  /// faces of different orientations; kInvalidArgument for more than one fan.
  void check_all() const;

 private:
  struct Side {
    std::uint64_t key;  ///< the other vertex of the edge, FaceSide
    std::uint32_t corner;
    bool leaves;  ///< the vertex, in the orientation of its face
  };

  void match(VertexId vertex, std::span<const Side> same_edge,
             std::span<const CornerAtVertex> corners);
  void find_first(std::span<const CornerAtVertex> corners);

  std::string source_;
  std::vector<Side> sides_;
  std::vector<std::uint32_t> twins_;
  std::vector<std::uint32_t> follows_;  ///< [corner] the next one counterclockwise, or kNoId
  std::size_t first_ = 0;
  bool is_on_border_ = false;
  std::uint64_t border_edges_ = 0;
  std::optional<Error> not_oriented_, not_one_fan_;
};

PLAIT_END_NAMESPACE
