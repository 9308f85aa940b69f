// sample/exact_faces.h: faces of a base mesh whose small triangles lie on the scan.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "distance/closest_point.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "sample/samples.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// [face of the base mesh] 1 where three points inside of each small triangle are on the scan, but
/// for rounding, and 0 elsewhere. Planes and prisms have such faces, and a base mesh that is the
/// scan. `tree` has the faces of the scan, `samples` are those of sample_scan(). All threads of the
/// present arena. What `go_on` throws ends the work. Pinned by tests/scans/relax_test.cpp.
std::vector<std::uint8_t> exact_faces(const Surface& scan, const TriangleTree& tree,
                                      const BaseMesh& base, int level,
                                      const std::vector<SurfacePoint>& samples,
                                      const std::function<void()>& go_on = {});

PLAIT_END_NAMESPACE
