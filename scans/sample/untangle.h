// sample/untangle.h: moves samples on the scan until fewer small triangles are turned over.
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

struct UntangleOptions {
  int rounds = 30;
  /// A sample wanders at most so far, in mean edges of its small triangles.
  double most_way = 2;
  /// [sample] 1: it stays (vertices_on_sides()). Empty: none does.
  std::span<const std::uint8_t> still_samples = {};
  /// The scan, if it has creases: samples do not cross its borders (cut_at()).
  const Surface* cut = nullptr;
  ProgressCallback progress = {};  ///< counts rounds, and what is before and after them
};

struct Untangled {
  std::uint64_t before = 0, after = 0;  ///< small triangles that are turned over
  std::uint64_t moved = 0;              ///< samples
};

/// Moves the corners of turned triangles, and their neighbours, along the faces of the scan. A
/// sample moves only if the penalty of the triangles around it falls, so no triangle turns over to
/// the worse in exchange. Samples on the border of the base mesh stay. `samples` are those of
/// sample_scan(). One thread. Errors: kOutOfMemory, kCancelled. Pinned by
/// tests/scans/untangle_test.cpp.
Untangled untangle(const Surface& scan, const BaseMesh& base, int level,
                   const UntangleOptions& options, std::vector<SurfacePoint>& samples);

PLAIT_END_NAMESPACE
