// A tree over the bounds of faces. Its leaves are the faces in layout order, and each inner node
// has the union of eight nodes that follow each other. Layouts keep neighbours together, so no
// other order is needed, and a query visits few nodes. (With a layout that scatters neighbours, a
// query visits more of them.)
#pragma once

#include <cstddef>
#include <vector>

#include "format/bounds_file.h"
#include "plait/bounds.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Immutable and safe from any number of threads.
class BoundsTree {
 public:
  explicit BoundsTree(std::vector<FaceBounds> faces);

  /// The faces whose bounds meet the box or touch it, ascending. Errors: kInvalidArgument if a
  /// component of the box is not a number.
  std::vector<FaceId> in_box(const Box& box) const;
  /// The faces whose bounds the ray meets or touches, the nearest first; at equal distances, in
  /// ascending order. Rounding never loses a face. Errors: kInvalidArgument if a component is not
  /// finite, or if the direction is zero.
  std::vector<FaceOnRay> along_ray(Vector3<double> origin, Vector3<double> direction) const;

 private:
  static constexpr std::size_t kChildren = 8;
  template <class Meets, class Visit>
  void search(std::size_t height, std::size_t node, const Meets& meets, Visit& visit) const;

  std::vector<std::vector<FaceBounds>> nodes_;  ///< [height]; height 0 has the faces
};

PLAIT_END_NAMESPACE
