// plait/layout.h: the order of base faces and edges, which is the order of slots on disk, and the
// size of the window that a sweep needs with that order.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Stored in manifests by name, never by number.
enum class LayoutKind : std::uint8_t {
  kGiven,      ///< the input's face order
  kSpatial,    ///< faces sorted along the longest axis of the bounding box (Guskov's paper)
  kHilbert,    ///< faces along a three-dimensional Hilbert curve
  kRcm,        ///< reverse Cuthill-McKee order of the faces' adjacency
  kAutomatic,  ///< the one of spatial, hilbert and rcm with the smallest span of the Loop stencils
};

std::string_view to_string(LayoutKind kind) noexcept;
/// Errors: kInvalidArgument; the message lists the known names.
LayoutKind layout_from_name(std::string_view name);

/// A permutation of the faces, order[new] = old. Deterministic.
/// Errors: kInvalidArgument for kAutomatic, which chooses an order and is none itself.
std::vector<FaceId> face_order(const BaseMesh& mesh, LayoutKind kind);

/// Differences of edge indices inside one stencil, over all stencils.
struct StencilSpan {
  std::uint64_t span = 0;  ///< the largest
  double mean_width = 0;   ///< the average
  /// For an even number of stencils, the lower of the two middle values.
  std::uint64_t median_width = 0;
};

/// The spans of a mesh in one order.
struct LayoutSpans {
  StencilSpan face;  ///< a face's three edges
  StencilSpan loop;  ///< an edge and the other edges of its two faces: five edges, three on borders
};
/// Measures the spans in the order that the mesh has now. O(F). Pinned by
/// tests/engine/layout/lay_out_test.cpp.
LayoutSpans measure_spans(const BaseMesh& mesh);

/// Bytes of the window that the paper's circular buffer needs to sweep levels 1 to `level` of one
/// attribute. The window holds the slots of 2 `span` edges on every level, which is 2 span (4^level
/// - 1)/3 records (section 4.2).
/// Errors: kInvalidArgument if `level` is not 0 to kMaxLevel, or the result exceeds 64 bits.
std::uint64_t window_bytes(std::uint64_t span, int level, std::uint64_t record_bytes);

/// A mesh whose edges and faces are in the order of a layout: what lay_out() returns, or a mesh as
/// it is.
struct LaidOutMesh {
  /// The mesh in the order that it has. Measures no spans.
  LaidOutMesh(BaseMesh given) : mesh(std::move(given)) {}
  LaidOutMesh(BaseMesh ordered, LayoutKind chosen, const LayoutSpans& measured)
      : mesh(std::move(ordered)), kind(chosen), spans(measured) {}

  BaseMesh mesh;
  LayoutKind kind = LayoutKind::kGiven;  ///< never kAutomatic
  LayoutSpans spans = {};                ///< all 0 unless they were measured
};
/// Puts the mesh in the order `kind`. For kAutomatic, lay_out() tries three orders in parallel and
/// takes the one with the smallest span; among equal spans it takes the first in the order of
/// LayoutKind. So the result is deterministic.
LaidOutMesh lay_out(const BaseMesh& mesh, LayoutKind kind);

PLAIT_END_NAMESPACE
