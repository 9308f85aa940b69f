#include "report_text.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

struct RepairLine {
  const char* name;  ///< in JSON
  const char* text;
};
constexpr std::array<RepairLine, 13> kRepairLines = {{
    {"not_finite_vertices", "vertices with coordinates that are not finite"},
    {"not_finite_faces", "faces at such vertices: removed"},
    {"degenerate_faces", "faces with a vertex twice: removed"},
    {"duplicate_faces", "faces given twice: removed"},
    {"needle_faces", "faces without area: they stay"},
    {"non_manifold_edges", "edges of more than two faces: cut apart"},
    {"turned_faces", "faces of the wrong orientation: turned"},
    {"non_manifold_vertices", "vertices of several fans: a vertex for each"},
    {"small_components", "small components: removed"},
    {"small_component_faces", "faces of small components"},
    {"filled_holes", "holes: filled"},
    {"filled_hole_faces", "faces that fill holes"},
    {"unused_vertices", "vertices that no face uses: removed"},
}};

std::string count_text(const Json& count) { return format_count(count.get<std::uint64_t>()); }

std::string counted(std::uint64_t count, const char* one, const char* many) {
  if (count == 0) return fmt::format("no {}", one);
  return fmt::format("{} {}", format_count(count), count == 1 ? one : many);
}

}  // namespace

std::string rounding_text(const Json& rounding) {
  return fmt::format(
      "rounded to steps of {:.6g}: error at most {:.6g} ({}), largest found {:.6g}, root mean "
      "square {:.6g}",
      rounding["step"].get<double>(), rounding["bound"].get<double>(),
      rounding["metric"].get<std::string>(), rounding["largest_error"].get<double>(),
      rounding["rms_error"].get<double>());
}

std::string made_blocks_text(const Json& made) {
  return fmt::format("{}: {} of {} blocks take no bytes; reading makes them again ({})\n",
                     made["attribute"].get<std::string>(), count_text(made["made"]),
                     count_text(made["blocks"]), made["recipe"].get<std::string>());
}

std::string repair_text(const Json& repairs) {
  std::string text;
  for (const RepairLine& line : kRepairLines)
    if (repairs[line.name].get<std::uint64_t>() > 0)
      text += fmt::format("  {} {}\n", count_text(repairs[line.name]), line.text);
  return text;
}

std::string figures_text(const Json& figures) {
  const auto number = [&](const char* name) { return figures[name].get<std::uint64_t>(); };
  return fmt::format(
      "{} vertices, {} edges, {} faces; {}, {}, Euler number {}", count_text(figures["vertices"]),
      count_text(figures["edges"]), count_text(figures["faces"]),
      counted(number("components"), "component", "components"),
      counted(number("borders"), "border", "borders"), figures["euler_number"].get<std::int64_t>());
}

std::string distances_text(std::string_view name, const Json& distances, double diagonal,
                           double mean_edge) {
  const auto number = [&](const char* of) { return distances[of].get<double>(); };
  const auto of_diagonal = [&](const char* of) { return 100 * number(of) / diagonal; };
  return fmt::format(
      "{}: RMS {:.4f} %, mean {:.4f} %, 99 % below {:.4f} %, 99.9 % below {:.4f} %, max {:.4f} % "
      "of "
      "the diagonal\n"
      "  RMS {:.3f}, max {:.2f} mean edges; normals differ by {:.2f} degrees in the mean, 99 % by "
      "less than {:.1f}\n",
      name, of_diagonal("rms"), of_diagonal("mean"), of_diagonal("percentile_99"),
      of_diagonal("percentile_99_9"), of_diagonal("max"), number("rms") / mean_edge,
      number("max") / mean_edge, number("mean_normal_degrees"),
      number("percentile_99_normal_degrees"));
}

}  // namespace plait
