// tools/scan_report.h: repairs, topology and distances of surfaces as text and JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "distance/distances.h"
#include "surface/repair.h"

namespace plait {

/// A line for each thing that was found, and what `plait remesh` does about it; empty for a clean
/// mesh.
std::string repair_text(const RepairList& list);
nlohmann::ordered_json repair_json(const RepairList& list);

/// "34,834 vertices, 104,496 edges, 69,664 faces; 1 component, no border, Euler number 2".
std::string figures_text(const SurfaceFigures& figures);
nlohmann::ordered_json figures_json(const SurfaceFigures& figures);

/// Two lines, in percent of `diagonal` and in mean edges. `name` says from where to where.
std::string distances_text(std::string_view name, const Distances& distances, double diagonal,
                           double mean_edge);
/// Lengths are in units of the meshes, "..._percent" in percent of the diagonal.
nlohmann::ordered_json distances_json(const Distances& distances, double diagonal);

}  // namespace plait
