// paper/tables.h: what the paper says of a mesh without running anything on it: counts, shares of
// vertices on base edges (section 2) and spans (section 5.3).
#pragma once

#include <nlohmann/json.hpp>

#include "plait/base_mesh.h"

namespace plait::paper {

/// {"vertices", "edges", "faces", "border_edges", "euler", "counts": [vertices of level k],
/// "shares":
/// [{"level", "born", "on_base_edges", "counted_born", "counted_on_base_edges"}], "replicated":
/// [vertices of level k if each patch had its own grid], "spans": [{"layout", "face", "loop"}]}.
/// The layouts are given, spatial (the paper's), hilbert and rcm. Counting takes O(vertices), so it
/// is done up to the level with at most `most_counted` vertices; there are no counted members
/// beyond.
nlohmann::json mesh_tables(const BaseMesh& mesh, int levels, std::uint64_t most_counted);

}  // namespace plait::paper
