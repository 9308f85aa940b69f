// remesh/scan_face_attributes.h: what a file says about the faces of a scan, as attributes of base
// faces.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "distance/closest_point.h"
#include "plait/detail/namespace.h"
#include "plait/extend/attributed_mesh.h"
#include "remesh/sampled_surface.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A face attribute of the store.
struct BaseFaceAttribute {
  MeshAttribute numbers;          ///< of the faces of the base mesh
  std::uint64_t mixed_faces = 0;  ///< of the base mesh: their scan has other numbers there too
};

/// How the number of a base face follows from the scan: each small face of the finest level counts
/// as much as its area, and has the number of the scan's face that is nearest to its middle.
/// Numbers of float32 and float64, and the colours red, green, blue and alpha, have their mean. Of
/// other integers, which may be labels, the base face gets the one that covers most of it; of those
/// that cover as much, the smallest. Pinned by tests/jobs/remesh_faces_test.cpp.
class ScanFaceAttributes {
 public:
  ScanFaceAttributes() = default;
  /// `attributes` are those of the faces before the repair, each of one component. `face_origin`:
  /// Repaired::face_origin. What fills a hole has no number: the nearest face that has one counts.
  ScanFaceAttributes(std::vector<MeshAttribute> attributes, std::vector<FaceId> face_origin)
      : attributes_(std::move(attributes)),
        face_origin_(attributes_.empty() ? std::vector<FaceId>() : std::move(face_origin)) {}

  bool empty() const { return attributes_.empty(); }
  /// Of the faces of surface.base. `tree` is that of `scan`, the repaired surface. Calls `go_on`
  /// about every 50 ms; what it throws ends the work. All threads of the present arena.
  std::vector<BaseFaceAttribute> of_base_faces(const Surface& scan, const TriangleTree& tree,
                                               const SampledSurface& surface,
                                               const std::function<void()>& go_on) const;

 private:
  std::vector<MeshAttribute> attributes_;
  std::vector<FaceId> face_origin_;  ///< [face of the repaired surface]
};

PLAIT_END_NAMESPACE
