// bench/paper/patch_diagram.h: Figure 2 of the paper, a patch that three interleaved quadtrees
// cover, as SVG.
#pragma once

#include <string>

namespace plait::paper {

/// One base face at `level`, 1 to 6. The colour of a vertex tells its base edge, its size the level
/// that created it. A line joins it to its parent: the vertex at (row / 2, column / 2) of the same
/// edge at the coarser level. The places come from to_side() of plait/extend/edge_index.h. Errors:
/// kInvalidArgument. Pinned by tests/bench/paper/paper_test.cpp.
std::string patch_diagram(int level);

}  // namespace plait::paper
