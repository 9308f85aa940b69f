// remesh/base_samples.h: the step of remesh() from a scan to a base mesh and its samples on the
// scan.
#pragma once

#include <vector>

#include "distance/closest_point.h"
#include "plait/detail/namespace.h"
#include "remesh/remesh.h"
#include "remesh/sampled_surface.h"
#include "remesh/scan_progress.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct BaseSamples {
  SampledSurface surface;  ///< without distances
  std::vector<SurfacePoint> samples;
};

/// Decimates the scan, and puts the vertices of all levels on it. With request.refuse_turned, this
/// is repeated while small triangles are turned over: that part of the scan counts more in the next
/// base mesh, which so has more faces there. Sets those numbers of the report that are about the
/// last base mesh; the seconds are those of all.
///
/// `tree` has the faces of the scan. All threads of the present arena, with the same result for
/// each number. Errors: kInvalidArgument
/// if small triangles are turned over in all base meshes, with their places; those of decimate(),
/// sample_scan(), relax() and untangle(). Pinned by tests/jobs/remesh_test.cpp.
BaseSamples make_base_samples(const RemeshRequest& request, const Surface& scan,
                              const TriangleTree& tree, WorkPart part, const ScanProgress& progress,
                              RemeshReport& report);

PLAIT_END_NAMESPACE
