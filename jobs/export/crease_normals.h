// export/crease_normals.h: normals at the creases of a store, where a vertex has one for each side.
//
// The face attribute "crease-sides" (uint8) says which sides of base faces are creases: bit s for
// the side opposite of corner s. plait remesh writes it where the scan has sharp edges.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/topology.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "render/patch_normal.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

constexpr std::string_view kCreaseSides = "crease-sides";

/// The vertices of a level that are on creases.
class CreasePoints {
 public:
  /// Without the attribute there are none. Errors: kInvalidArgument if it has other numbers.
  CreasePoints(const Store& store, int level);

  bool empty() const { return marks_.empty(); }
  /// Of these faces.
  std::uint64_t vertex_count(const BaseMesh& base, std::span<const FaceId> faces) const;
  bool has_any(FaceId face) const { return !empty() && marks_[face] != 0; }
  bool is_crease(FaceSide side) const { return ((marks_[side.face()] >> side.side()) & 1) != 0; }
  /// Whether the vertex of a corner is the end of a crease.
  bool is_crease_corner(FaceId face, int corner) const {
    return ((marks_[face] >> (3 + corner)) & 1) != 0;
  }
  /// Calls visit(i, j) for the points of a face that are on creases: its corners, then its sides.
  template <class Visit>
  void for_each_point(FaceId face, Visit visit) const {
    if (!has_any(face)) return;
    for (int corner = 0; corner < 3; ++corner)
      if (is_crease_corner(face, corner)) visit(corner == 1 ? size_ : 0, corner == 2 ? size_ : 0);
    for (int side = 0; side < 3; ++side)
      if (is_crease(FaceSide(face, side)))
        for (std::int64_t part = 1; part < size_; ++part)
          visit(side == 1 ? 0 : part, side == 2 ? 0 : side == 1 ? part : size_ - part);
  }
  std::int64_t size() const { return size_; }

 private:
  std::int64_t size_;
  std::vector<std::uint8_t> marks_;  ///< [face] bits of sides, and 3 above them of corners
};

/// The positions of one patch after another, as doubles.
class PatchPositions {
 public:
  PatchPositions(const Store& store, int level);

  void read(FaceId face);
  Vector3<double> at(std::int64_t i, std::int64_t j) const;

 private:
  Reader reader_;
  int level_;
  bool wide_;
  std::optional<PatchView> patch_;
  std::optional<RecordView> records_;
};

/// The normals of those vertices on each side: the mean of the normals of the triangles around the
/// vertex up to the next crease, weighted by area. Pinned by
/// tests/jobs/export/crease_normals_test.cpp.
class CreaseNormals {
 public:
  /// Reads the patches at the ends of creases. REQUIRES: faces have no depths of their own. Calls
  /// `go_on` for each patch; what it throws ends the work.
  CreaseNormals(const Store& store, int level, const std::function<void()>& go_on = {});

  const CreasePoints& points() const { return points_; }
  /// Calls visit(i, j, normal) for the points of a face that are on creases; at(i, j) is the
  /// position of a point of the face. A normal has the length 1, or 0 where triangles have no area.
  template <class At, class Visit>
  void for_each(FaceId face, const At& at, Visit visit) const {
    const OneSide<At> patch{at};
    points_.for_each_point(face, [&](std::int64_t i, std::int64_t j) {
      const std::int64_t size = points_.size();
      if (i == size || j == size || (i == 0 && j == 0))
        visit(i, j, corner_normals_[3 * std::size_t{face} + (i == size ? 1 : j == size ? 2 : 0)]);
      else
        visit(i, j, patch_normal(patch, 0, size, i, j));
    });
  }

 private:
  /// For patch_normal(): a patch that ends at its sides.
  template <class At>
  struct OneSide {
    const At& positions;
    Vector3<double> at(int, std::int64_t i, std::int64_t j) const { return positions(i, j); }
    bool is_border(int) const { return true; }
  };

  CreasePoints points_;
  std::vector<Vector3<float>> corner_normals_;  ///< [3 face + corner]
};

PLAIT_END_NAMESPACE
