// Numbers for the vertices and faces of a mesh so that what is near in space is near in memory. The
// order of a file may lead every walk over the mesh to memory that no cache holds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The faces of a file with numbers of their own for vertices and faces.
struct LocalMesh {
  HugeArray<FaceVertices> faces;
  HugeArray<VertexId> file_vertices;  ///< [vertex] its number in the file
  HugeArray<FaceId> file_faces;       ///< [face] its number in the file
};

/// Cells of a grid over the bounds of some points; cells with near numbers are near each other.
class PlaceGrid {
 public:
  static constexpr int kBitsOfAxis = 6;
  static constexpr std::uint32_t kCells = std::uint32_t{1} << 3 * kBitsOfAxis;

  void include(const Vector3<double>& point);
  /// REQUIRES: include() has got the point.
  std::uint32_t cell(const Vector3<double>& point) const;

 private:
  Vector3<double> low_{}, high_{};
  bool is_empty_ = true;
};

/// Numbers the vertices by their cells, cells[vertex of the file], and the faces by their vertices.
/// The corners of a face stay in their order. What was in `faces` is lost. Takes time in proportion
/// to the mesh, and no memory beside the result.
/// REQUIRES: check_faces() has passed.
LocalMesh local_mesh(std::span<FaceVertices> faces, HugeArray<std::uint32_t> cells);
/// The faces as the file has them.
std::vector<FaceVertices> faces_of_file(const LocalMesh& mesh);

PLAIT_END_NAMESPACE
