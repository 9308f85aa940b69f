// bench/paper/models.h: the three meshes of Guskov's paper, the figures that it gives for them, and
// stand-ins with the same counts.
//
// Source of the figures: I. Guskov, "Non-replicating indexing for out-of-core processing of
// semi-regular triangular surface meshes", sections 2, 5.3 and 6.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::paper {

/// How a stand-in is made: a molecule of this number of vertices from a seed, refined by Loop's
/// rule so often, and reduced by edge collapse, which keeps the genus. So vertices and edges are
/// those of the paper's mesh.
struct StandIn {
  std::uint64_t molecule_vertices, seed;
  int refinements;
};

/// A mesh of the paper, and what the paper says of it. Times are in seconds.
struct Model {
  std::string_view name, title;
  std::uint64_t vertices, edges;
  int levels;                               ///< the level that the paper refines it to
  std::uint64_t face_span, loop_span;       ///< with the paper's order (section 5.3)
  std::vector<double> elapsed;              ///< with one budget after another
  std::vector<std::uint64_t> memory_bytes;  ///< likewise: the paper's main claim
  double processor_seconds;
  std::uint64_t disk_bytes;  ///< as the paper rounds it
  StandIn stand_in;
};

std::span<const Model> models();
/// Errors: kInvalidArgument; the message lists the known names.
const Model& model_from_name(std::string_view name);

/// The stand-in of a model, or, if `vertices` is not 0, a molecule of this number of vertices.
/// Errors: kInvalidArgument for a count that generate() refuses. Pinned by
/// tests/bench/paper/paper_test.cpp.
IndexedMesh make_stand_in(const Model& model, std::uint64_t vertices);
/// "a molecule from seed 5, ..." for reports.
std::string describe_stand_in(const Model& model, std::uint64_t vertices);

}  // namespace plait::paper
