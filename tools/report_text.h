// tools/report_text.h: what several reports have (report_json.h of jobs/), as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace plait {

/// "rounded to steps of 2e-5: error at most 1e-5 (component), largest found 9.9e-6, ..."
std::string rounding_text(const nlohmann::ordered_json& rounding);

/// "normal: 96 of 96 blocks take no bytes; reading makes them again (normals/position/5)", and a
/// line end.
std::string made_blocks_text(const nlohmann::ordered_json& made);

/// A line for each thing that was found, and what `plait remesh` does about it; empty for a clean
/// mesh.
std::string repair_text(const nlohmann::ordered_json& repairs);

/// "34,834 vertices, 104,496 edges, 69,664 faces; 1 component, no border, Euler number 2".
std::string figures_text(const nlohmann::ordered_json& figures);

/// Two lines, in percent of `diagonal` and in mean edges. `name` says from where to where.
std::string distances_text(std::string_view name, const nlohmann::ordered_json& distances,
                           double diagonal, double mean_edge);

}  // namespace plait
