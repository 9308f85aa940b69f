// remesh/scan_attributes.h: the vertex attributes of a scan, at the points of the scan that become
// vertices of a store.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/attributed_mesh.h"
#include "plait/progress.h"
#include "plait/store.h"
#include "surface/repair.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Adds a line to `warnings` for each attribute of vertices or faces that has values which are
/// infinite or no numbers.
void warn_of_values_not_finite(const AttributedMesh& scan, std::vector<std::string>& warnings);

/// How the record of a point follows from those of the corners of its face: numbers of float32 and
/// float64, and colours, are interpolated, and normals get length 1. Any other integer may be a
/// label, which has no mean: the record is that of the nearest corner. Pinned by
/// tests/jobs/remesh_test.cpp.
class ScanAttributes {
 public:
  ScanAttributes() = default;
  /// `attributes` are those of the mesh before the repair, and repaired.origin says which of their
  /// records belong to which vertex. A vertex that fills a hole gets the mean of its neighbours
  /// that are nearer to the border.
  ScanAttributes(std::vector<MeshAttribute> attributes, const Repaired& repaired);

  std::size_t count() const { return attributes_.size(); }
  const AttributeSchema& schema(std::size_t attribute) const {
    return attributes_[attribute].schema;
  }
  /// Writes the record at a point of `scan`, the repaired surface. Threads: any number.
  void record_at(std::size_t attribute, const Surface& scan, const SurfacePoint& at,
                 std::byte* to) const;

 private:
  void fill_holes(const Surface& scan);
  void blend(std::size_t attribute, std::span<const VertexId> records,
             std::span<const double> weights, std::byte* to) const;

  std::vector<MeshAttribute> attributes_;
  std::vector<VertexId> record_of_;  ///< [vertex of the repaired surface]
};

PLAIT_END_NAMESPACE
