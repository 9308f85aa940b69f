// report_json.h: what the reports of several jobs have, as JSON. In a header, because the program's
// own commands say the same.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "distance/distances.h"
#include "plait/attribute.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/rounding.h"
#include "plait/extend/store_access.h"
#include "plait/store.h"
#include "surface/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline nlohmann::ordered_json rounding_json(const Rounding& rounding) {
  return {{"metric", to_string(rounding.metric)},
          {"bound", rounding.bound},
          {"step", rounding.step},
          {"largest_error", rounding.largest_error},
          {"rms_error", rounding.rms_error}};
}

/// Lengths are in units of the meshes, "..._percent" in percent of the diagonal.
inline nlohmann::ordered_json distances_json(const Distances& distances, double diagonal) {
  const double percent = 100 / diagonal;
  return {{"samples", distances.samples},
          {"rms", distances.rms},
          {"mean", distances.mean},
          {"percentile_99", distances.percentile_99},
          {"percentile_99_9", distances.percentile_99_9},
          {"max", distances.max},
          {"rms_percent", percent * distances.rms},
          {"max_percent", percent * distances.max},
          {"mean_normal_degrees", distances.mean_angle},
          {"percentile_99_normal_degrees", distances.percentile_99_angle}};
}

inline nlohmann::ordered_json figures_json(const SurfaceFigures& figures) {
  return {{"vertices", figures.vertices},
          {"edges", figures.edges},
          {"faces", figures.faces},
          {"components", figures.components},
          {"borders", figures.borders},
          {"border_edges", figures.border_edges},
          {"euler_number", figures.euler_number},
          {"folded_edges", figures.folded_edges}};
}

inline nlohmann::ordered_json repairs_json(const RepairList& list) {
  return {{"clean", list.is_clean()},
          {"vertices", list.vertices},
          {"faces", list.faces},
          {"not_finite_vertices", list.not_finite_vertices},
          {"not_finite_faces", list.not_finite_faces},
          {"degenerate_faces", list.degenerate_faces},
          {"duplicate_faces", list.duplicate_faces},
          {"needle_faces", list.needle_faces},
          {"non_manifold_edges", list.non_manifold_edges},
          {"turned_faces", list.turned_faces},
          {"non_manifold_vertices", list.non_manifold_vertices},
          {"small_components", list.small_components},
          {"small_component_faces", list.small_component_faces},
          {"filled_holes", list.filled_holes},
          {"filled_hole_faces", list.filled_hole_faces},
          {"unused_vertices", list.unused_vertices}};
}

inline nlohmann::ordered_json attributes_json(const std::vector<AttributeSchema>& schemas) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const AttributeSchema& schema : schemas)
    json.push_back({{"name", schema.name},
                    {"type", to_string(schema.type)},
                    {"components", schema.components}});
  return json;
}

/// [level] the number of faces that have no finer one: {"level", "faces"} for each level that has
/// any.
inline nlohmann::ordered_json depths_json(std::span<const std::uint64_t> faces_of_level) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (std::size_t level = 0; level < faces_of_level.size(); ++level)
    if (faces_of_level[level] > 0)
      json.push_back({{"level", level}, {"faces", faces_of_level[level]}});
  return json;
}

/// The blocks of an attribute that a store makes again instead of containing them: {"attribute",
/// "made", "blocks", "recipe"}; null if every block takes bytes.
inline nlohmann::ordered_json made_blocks_json(const Store& store, AttributeId attribute) {
  const auto& [schema, finest] = store.attributes()[attribute];
  std::uint64_t blocks = 0, made = 0;
  std::string recipe;
  for (int level = store.base_level() + 1; level <= finest; ++level) {
    const LevelFile& file = StoreAccess::level_file(store, attribute, level);
    for (const BlockEntry& entry : file.table.entries()) {
      ++blocks;
      if (entry.encoding != BlockEncoding::kPredicted) continue;
      ++made;
      recipe = file.pipeline.recipe.value_or("");
    }
  }
  if (made == 0) return nullptr;
  return {{"attribute", schema.name}, {"made", made}, {"blocks", blocks}, {"recipe", recipe}};
}

/// Those of all attributes of a store on the disk; an empty array for a store that is only in
/// memory, which has no path.
inline nlohmann::ordered_json made_blocks_json(const std::filesystem::path& path,
                                               const BackendRegistry& backends) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  if (path.empty()) return json;
  const Store store = Store::open(path, {}, backends);
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (nlohmann::ordered_json of_one = made_blocks_json(store, id); !of_one.is_null())
      json.push_back(std::move(of_one));
  return json;
}

PLAIT_END_NAMESPACE
