// remesh/choose_depths.h: the end of remesh() with a largest distance: the depth of each face.
#pragma once

#include <functional>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/store.h"
#include "remesh/remesh.h"
#include "remesh/sampled_surface.h"
#include "remesh/scan_progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Sets the distances of the report to those of `drawn`, and returns the largest, vertices of the
/// scan included. The two parts are those of its two directions.
using MeasureDrawn =
    std::function<double(const IndexedMesh& drawn, WorkPart to_store, WorkPart to_scan)>;

/// Prunes towards all levels, and measures how far what is left is from the scan, until that is
/// near enough. Returns the base mesh with the depths, and sets those numbers of the report that
/// are about them. REQUIRES: the report has max_distance, and the distances of all levels.
/// `all_levels` is a store of `surface`. Errors: kCancelled; those of depths_by_distance().
/// Pinned by tests/jobs/remesh_depths_test.cpp.
BaseMesh choose_depths(Store& all_levels, const SampledSurface& surface, WorkPart part,
                       const ScanProgress& progress, const MeasureDrawn& measure,
                       RemeshReport& report);

PLAIT_END_NAMESPACE
