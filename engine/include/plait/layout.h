// plait/layout.h: the order of base faces and edges, which is the order of slots on disk, and what
// it asks of a window.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"

namespace plait {

/// Stored in manifests by name, never by number.
enum class LayoutKind : std::uint8_t {
  kGiven,      ///< the input's face order
  kSpatial,    ///< faces sorted along the longest axis of the bounding box (Guskov's paper)
  kHilbert,    ///< faces along a three-dimensional Hilbert curve
  kRcm,        ///< reverse Cuthill-McKee order of the faces' adjacency
  kAutomatic,  ///< the one of spatial, hilbert and rcm with the smallest span of the Loop stencils
};

std::string_view to_string(LayoutKind kind) noexcept;
/// Errors: kInvalidArgument naming the layouts there are.
LayoutKind layout_from_name(std::string_view name);

/// A permutation of the faces, order[new] = old. Deterministic.
/// Errors: kInvalidArgument for kAutomatic, which is a choice and not an order.
std::vector<FaceId> face_order(const BaseMesh& mesh, LayoutKind kind);

/// Differences of edge indices inside one stencil, over all stencils.
struct StencilSpan {
  std::uint64_t span = 0;          ///< the largest
  double mean_width = 0;           ///< the average
  std::uint64_t median_width = 0;  ///< the lower one of the two for an even number of stencils
};

struct LayoutSpans {
  StencilSpan face;  ///< a face's three edges
  StencilSpan loop;  ///< an edge and the other edges of its two faces: five edges, three on borders
};
/// In the order that the mesh has now. O(F). Pinned by tests/engine/layout/spans_test.cpp.
LayoutSpans measure_spans(const BaseMesh& mesh);

/// The window the paper's circular buffer needs to sweep levels 1 to `level` of one attribute:
/// slots of twice `span` edges on every level: 2 span (4^level - 1)/3 records (section 4.2).
/// Errors: kInvalidArgument if `level` is not 0 to kMaxLevel, or the result exceeds 64 bits.
std::uint64_t window_bytes(std::uint64_t span, int level, std::uint64_t record_bytes);

struct LaidOutMesh {
  BaseMesh mesh;
  LayoutKind kind;  ///< never kAutomatic: the one that was taken
  LayoutSpans spans;
};
/// The mesh in the order asked for; kAutomatic keeps the best of its three, the first of equals.
/// They are tried in parallel; the result does not depend on it.
LaidOutMesh lay_out(const BaseMesh& mesh, LayoutKind kind);

}  // namespace plait
