// remesh/sampled_surface.h: the base mesh and the samples that become a store.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "distance/closest_point.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "plait/store.h"
#include "remesh/scan_attributes.h"
#include "sample/samples.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct SampledSurface {
  BaseMesh base;  ///< its faces are in layout order; its vertices are points of the scan
  int levels = 0;
  std::vector<Point> positions;      ///< by SampleNumbers, with numbers that the store can have
  std::vector<std::uint8_t> turned;  ///< by SampleNumbers: 1 at corners of turned ones
  std::vector<float> distances;      ///< by SampleNumbers; empty unless asked for
  /// [face of the base mesh] bit s: side s is a crease. Empty: there are none.
  std::vector<std::uint8_t> crease_sides;
};

/// Adds the attributes "position" (of `precision`), "turned" and, unless it is empty, "distance",
/// and writes all their levels. `progress` counts the vertices of all of them.
void write_levels(const SampledSurface& surface, ComponentType precision, Store& store, int threads,
                  const ProgressCallback& progress);

struct AttributeWriting {
  int threads = 1;
  ProgressCallback progress = {};  ///< counts faces of the base mesh, those of all attributes
  std::function<void(int threads)> begins = {};  ///< as in PatchFilling
};

/// Adds the attributes of the scan, and writes all their levels: the records at `samples`, which
/// are in the order of SampleNumbers. Errors: kCancelled; those of PatchWriter.
void write_attributes(const ScanAttributes& attributes, const Surface& scan,
                      std::span<const SurfacePoint> samples, const SampledSurface& surface,
                      Store& store, const AttributeWriting& options);

/// The small triangles of the finest level, in doubles.
IndexedMesh small_triangles(const SampledSurface& surface);
/// What is drawn of `deep`, the same base mesh with depths (docs/adaptive.md). The positions are
/// all that the surface has.
IndexedMesh drawn_triangles(const SampledSurface& surface, const BaseMesh& deep);

/// The largest distance of a vertex of the scan from the triangles of the tree. All threads of the
/// present arena.
double farthest_vertex(const Surface& scan, const TriangleTree& tree);

/// How far the scan is from the small triangles, of which `tree` is: at each sample, the largest
/// distance of those vertices of the scan whose closest triangle has it as a corner, or 0. All
/// threads of the present arena.
std::vector<float> distances_at_samples(const Surface& scan, const IndexedMesh& small,
                                        const TriangleTree& tree);

PLAIT_END_NAMESPACE
