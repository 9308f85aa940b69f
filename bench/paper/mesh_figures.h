// bench/paper/mesh_figures.h: what the paper says of a mesh without running anything on it: counts,
// shares of vertices on base edges (section 2), spans (section 5.3), and Figures 6 and 7.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>

#include "picture/image.h"
#include "plait/base_mesh.h"
#include "plait/layout.h"

namespace plait::paper {

/// {"vertices", "edges", "faces", "euler", "shares": [{"level", "born", "on_base_edges",
/// "vertices", "replicated"}], "spans": [{"layout", "face", "loop", "loop_median"}]}.
///
/// `shares` has a row for each of levels 1 to `levels`: the vertices that the level creates, those
/// of them on base edges, which a format with a grid for each patch would store twice, and the
/// vertices up to the level, with one numbering and with such grids. It comes from the counts of
/// the mesh alone: with n = 2^(level - 1), an inner edge has n n new vertices and a border edge
/// n (n + 1) / 2, of which n lie on the edge, so in a closed mesh the share on base edges is 1 / n.
/// With grids there are F (2 n + 1) (2 n + 2) / 2 vertices. Pinned by
/// tests/bench/paper/paper_test.cpp, which counts points.
///
/// The layouts of `spans` are given, spatial (the paper's), hilbert and rcm.
nlohmann::json mesh_tables(const BaseMesh& mesh, int levels);

/// Figures 6 and 7: the span diagram of the mesh in the given order, with the most pixels that its
/// width may have.
Image span_picture(const BaseMesh& mesh, LayoutKind order, std::size_t most_width);

/// The picture with half the width and height; each pixel is the mean of four. An odd last row or
/// column is left out. REQUIRES: at least 2 x 2 pixels.
Image halved(const Image& image);

}  // namespace plait::paper
