// sample/relax.h: moves samples on the scan until small triangles follow it more closely.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "sample/samples.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct RelaxOptions {
  int rounds = 6;
  /// After this number of rounds, samples try fewer places, and stay if the estimate around them is
  /// less than the mean one.
  int full_rounds = 3;
  /// A small triangle has at most this number of times the mean area of its base face's small
  /// triangles, and at least that part of it, unless it was beyond before.
  double most_ratio = 2;
  /// [face of the base mesh] 1: its samples stay (exact_faces()). Empty: none do.
  std::span<const std::uint8_t> still_faces = {};
  /// [sample] 1: it stays (vertices_on_sides()). Empty: none does.
  std::span<const std::uint8_t> still_samples = {};
  ProgressCallback progress = {};  ///< counts faces, edges and vertices, in each round
};

/// Moves samples along the faces of the scan, in each round by shorter ways. A sample moves if the
/// estimated squared distances between the scan and the small triangles around it fall
/// (sample_ring.h). No triangle turns over in exchange, unless one beside it is turned already.
/// Samples on the border of the base mesh stay, and no sample crosses a border of the scan. Returns
/// how many samples moved.
///
/// `samples` are those of sample_scan(). All threads of the present arena, with the same result for
/// each number. Memory: 180 bytes a sample, and 48 bytes a vertex of the scan. Errors: kCancelled.
/// Pinned by tests/scans/relax_test.cpp.
std::uint64_t relax(const Surface& scan, const BaseMesh& base, int level,
                    const RelaxOptions& options, std::vector<SurfacePoint>& samples);

PLAIT_END_NAMESPACE
