// collapse/decimate.h: a scan becomes a base mesh of few faces, by collapses of edges, and each
// point of the base mesh stays a point of the scan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collapse/collapse_history.h"
#include "collapse/tiles.h"
#include "plait/detail/namespace.h"
#include "plait/progress.h"
#include "surface/creases.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct DecimateOptions {
  std::uint64_t faces = 0;  ///< stop at this number of faces, or one more
  std::size_t tile_faces = kTileFaces;
  /// [vertex of the scan] its quadric counts this number of times, so that larger numbers leave
  /// more faces there. Empty: all count once.
  std::span<const float> weights = {};
  /// No face turns far from those that it replaces while any other edge can collapse. The base mesh
  /// is farther from thin parts, but fewer small triangles turn over on fins.
  bool firm = false;
  /// Vertices of a crease stay on it, and its corners where they are.
  const Creases* creases = nullptr;
  ProgressCallback progress = {};  ///< counts faces that are gone, of those that shall go
};

/// Why no more edges could collapse.
struct DecimateLimits {
  std::uint64_t by_topology =
      0;                       ///< edges whose collapse would change genus, borders or components
  std::uint64_t by_shape = 0;  ///< edges whose collapse would turn a face or make a needle
};

/// A base mesh and the way back to the scan. Vertices and faces keep the order of the scan.
struct Decimated {
  std::vector<Point> positions;  ///< near the scan, not on it
  std::vector<std::array<VertexId, 3>> faces;
  std::vector<FaceId> scan_faces;  ///< [face] the number that `history` knows it by
  /// [3 face + side] 1: a crease. Empty: there are none.
  std::vector<std::uint8_t> crease_sides;
  CollapseHistory history{0};
  DecimateLimits limits;  ///< of the edges left, if the faces are more than asked for
};

/// Collapses edges, cheapest first, until at most options.faces faces are left (one more if the
/// last collapse is at no border), or until no edge can collapse. Genus, components and borders
/// stay.
///
/// The cost of a collapse is the sum of squared distances to the planes of the scan's faces,
/// weighted by area, at the best place of the new vertex; times the square of the stretch: the area
/// of scan that the new faces carry over their own; and larger for thin faces and many of them.
/// Borders have planes of their own, at right angles to their faces. A vertex on the border stays
/// on it, and corners of borders stay where they are (border_corners.h). Creases are as borders
/// that have two sides: points of a crease of the base mesh are on the crease of the scan.
///
/// Edges inside of tiles collapse first, until ten times as many faces are left as asked for, on
/// all threads of the present arena. Then all edges do, on one thread, and faces may turn further
/// and be thinner, so that no part of the surface locks; in the end as far as the layout of a
/// collapse in the plane allows. Where more than a twentieth of the scan's edges turn by more than
/// 60 degrees, besides creases, nothing else limits the shape of faces. The result depends on the
/// surface and the options alone. Memory: about 200 bytes for a face of the scan. Errors:
/// kCancelled, kNotSupported (collapse_history.h). Pinned by tests/scans/decimate_test.cpp.
Decimated decimate(const Surface& scan, const DecimateOptions& options);

PLAIT_END_NAMESPACE
