// distance/closest_point.h: the closest point of many triangles, by a tree of boxes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_NAMESPACE

struct ClosestPoint {
  Point point{};
  double squared_distance = std::numeric_limits<double>::infinity();
  FaceId face = kNoId;
};

/// The closest point of the triangle abc (C. Ericson, "Real-time collision detection",
/// 2005, 5.1.5).
Point closest_of_triangle(Point p, Point a, Point b, Point c);

/// Threads: any number may search at once. Pinned by tests/scans/distances_test.cpp, by brute
/// force.
class TriangleTree {
 public:
  /// The spans must outlive the tree. There is at least one face. Memory: about 24 bytes a face.
  /// Calls `go_on`, if it is set, after some 10,000 faces at most; what it throws ends the work.
  TriangleTree(std::span<const Point> positions, std::span<const std::array<VertexId, 3>> faces,
               const std::function<void()>& go_on = {});

  /// The closest point of all faces. `hint` is a face that may be near: the nearer it is, the
  /// faster the search.
  ClosestPoint closest(Point p, FaceId hint = 0) const;
  /// Calls visit(face) for the faces whose boxes, or those of faces near them, meet the box of
  /// `points`, until it returns false.
  template <class Visit>
  void for_faces_in_box(const std::array<Point, 3>& points, Visit&& visit) const {
    const Box box = box_around(points);
    std::array<std::uint32_t, 64> stack;  // halves of halves: at most 32 levels
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t at = stack[--depth];
      const Node& node = nodes_[at];
      bool meets = true;
      for (std::size_t axis = 0; axis < 3; ++axis)
        meets = meets && node.low[axis] <= box.high[axis] && box.low[axis] <= node.high[axis];
      if (!meets) continue;
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (!visit(order_[i])) return;
      if (node.count > 0) continue;
      stack[depth++] = node.first;
      stack[depth++] = at + 1;
    }
  }

 private:
  struct Node {
    std::array<float, 3> low, high;
    std::uint32_t first;  ///< of a leaf: of order_; else the second child, the first one comes next
    std::uint32_t count;  ///< faces of a leaf; 0 for others
  };
  struct Box {
    std::array<float, 3> low, high;
  };
  Box box_around(const std::array<Point, 3>& points) const;
  void choose_origin();
  void build(std::uint32_t first, std::uint32_t count, std::vector<Point>& middles,
             const std::function<void()>& go_on);
  void offer(Point p, FaceId face, ClosestPoint& best) const;

  /// Boxes are kept in float, so they are relative to this point where the triangles are far from
  /// the origin: there float has no numbers between them.
  Point origin_{};
  std::span<const Point> positions_;
  std::span<const std::array<VertexId, 3>> faces_;
  std::vector<FaceId> order_;
  std::vector<Node> nodes_;
};

PLAIT_END_NAMESPACE
