// face_divider.h: divides the faces of a file into triangles.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "mesh/files/input.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Takes faces corner by corner, and divides each into triangles around the face's first corner. It
/// does not store corners, so a face of a million corners needs only the memory of its triangles.
/// When all positions are there, finish() divides those polygons anew for which these triangles are
/// wrong: they are found again from their triangles, of which there are as many in any division.
class FaceDivider {
 public:
  explicit FaceDivider(IndexedMesh& mesh) : mesh_(mesh) {}

  void begin();
  /// Returns false if there are now more triangles than a base mesh can have.
  bool add(VertexId vertex);
  /// A face of three corners, which add() need not see.
  void add_triangle(const std::array<VertexId, 3>& face);
  std::uint64_t corners() const { return corners_; }  ///< of the current face, so far

  /// Errors: kInvalidArgument for a polygon that cannot be divided, with its number, counted from
  /// `first_number`. REQUIRES: all corners name positions.
  void finish(const Input& input, std::uint64_t first_number, std::vector<std::string>* warnings);

 private:
  IndexedMesh& mesh_;
  FaceId faces_ = 0;  ///< that have begun
  std::uint64_t corners_ = 0;
  VertexId first_ = 0, previous_ = 0;
};

PLAIT_END_NAMESPACE
