#include "scan_report.h"

#include <fmt/format.h>

#include <array>

#include "argument_text.h"

namespace plait {
namespace {

struct RepairLine {
  std::uint64_t RepairList::*count;
  const char* name;  ///< in JSON
  const char* text;
};
constexpr std::array<RepairLine, 13> kLines = {{
    {&RepairList::not_finite_vertices, "not_finite_vertices",
     "vertices with coordinates that are not finite"},
    {&RepairList::not_finite_faces, "not_finite_faces", "faces at such vertices: removed"},
    {&RepairList::degenerate_faces, "degenerate_faces", "faces with a vertex twice: removed"},
    {&RepairList::duplicate_faces, "duplicate_faces", "faces given twice: removed"},
    {&RepairList::needle_faces, "needle_faces", "faces without area: they stay"},
    {&RepairList::non_manifold_edges, "non_manifold_edges",
     "edges of more than two faces: cut apart"},
    {&RepairList::turned_faces, "turned_faces", "faces of the wrong orientation: turned"},
    {&RepairList::non_manifold_vertices, "non_manifold_vertices",
     "vertices of several fans: a vertex for each"},
    {&RepairList::small_components, "small_components", "small components: removed"},
    {&RepairList::small_component_faces, "small_component_faces", "faces of small components"},
    {&RepairList::filled_holes, "filled_holes", "holes: filled"},
    {&RepairList::filled_hole_faces, "filled_hole_faces", "faces that fill holes"},
    {&RepairList::unused_vertices, "unused_vertices", "vertices that no face uses: removed"},
}};

std::string counted(std::uint64_t count, const char* one, const char* many) {
  if (count == 0) return fmt::format("no {}", one);
  return fmt::format("{} {}", format_count(count), count == 1 ? one : many);
}

}  // namespace

std::string repair_text(const RepairList& list) {
  std::string text;
  for (const RepairLine& line : kLines)
    if (list.*line.count > 0)
      text += fmt::format("  {} {}\n", format_count(list.*line.count), line.text);
  return text;
}

nlohmann::ordered_json repair_json(const RepairList& list) {
  nlohmann::ordered_json report = {
      {"clean", list.is_clean()}, {"vertices", list.vertices}, {"faces", list.faces}};
  for (const RepairLine& line : kLines) report[line.name] = list.*line.count;
  return report;
}

std::string figures_text(const SurfaceFigures& figures) {
  return fmt::format("{} vertices, {} edges, {} faces; {}, {}, Euler number {}",
                     format_count(figures.vertices), format_count(figures.edges),
                     format_count(figures.faces),
                     counted(figures.components, "component", "components"),
                     counted(figures.borders, "border", "borders"), figures.euler_number);
}

nlohmann::ordered_json figures_json(const SurfaceFigures& figures) {
  return {{"vertices", figures.vertices},
          {"edges", figures.edges},
          {"faces", figures.faces},
          {"components", figures.components},
          {"borders", figures.borders},
          {"border_edges", figures.border_edges},
          {"euler_number", figures.euler_number},
          {"folded_edges", figures.folded_edges}};
}

std::string distances_text(std::string_view name, const Distances& distances, double diagonal,
                           double mean_edge) {
  const auto of_diagonal = [&](double length) { return 100 * length / diagonal; };
  return fmt::format(
      "{}: RMS {:.4f} %, mean {:.4f} %, 99 % below {:.4f} %, 99.9 % below {:.4f} %, max {:.4f} % "
      "of "
      "the diagonal\n"
      "  RMS {:.3f}, max {:.2f} mean edges; normals differ by {:.2f} degrees in the mean, 99 % by "
      "less than {:.1f}\n",
      name, of_diagonal(distances.rms), of_diagonal(distances.mean),
      of_diagonal(distances.percentile_99), of_diagonal(distances.percentile_99_9),
      of_diagonal(distances.max), distances.rms / mean_edge, distances.max / mean_edge,
      distances.mean_angle, distances.percentile_99_angle);
}

nlohmann::ordered_json distances_json(const Distances& distances, double diagonal) {
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

}  // namespace plait
