// plait remesh: makes a store from a scan.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "base/text.h"
#include "job_command.h"
#include "report_text.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string number_text(const Json& json) { return format_count(json.get<std::uint64_t>()); }

std::string limits_text(const Json& report) {
  const auto asked = report["faces_asked"].get<std::uint64_t>();
  if (report["base_figures"]["faces"].get<std::uint64_t>() <= asked + 1) return {};
  return fmt::format(
      "  more than the {} faces asked for: {} edges are kept by genus, borders or components, {} "
      "by "
      "the shape of faces\n",
      format_count(asked), number_text(report["edges_kept_by_topology"]),
      number_text(report["edges_kept_by_shape"]));
}

std::string base_text(const Json& report) {
  std::string text = fmt::format("{}: {}\n", report["scan"].get<std::string>(),
                                 figures_text(report["scan_figures"]));
  if (!report["repairs"]["clean"].get<bool>())
    text += "repaired:\n" + repair_text(report["repairs"]);
  text += fmt::format("base mesh: {}\n", figures_text(report["base_figures"]));
  if (report["base_meshes"].get<std::uint64_t>() > 1)
    text += fmt::format("  made {} times, until no small face was turned over\n",
                        number_text(report["base_meshes"]));
  text += limits_text(report);
  if (const auto trials = report["trials"].get<std::uint64_t>(); trials > 0)
    text += fmt::format("  base mesh {} that was tried: all points are within {:.6g}\n", trials,
                        report["max_distance"].get<double>());
  if (const auto edges = report["crease_edges"].get<std::uint64_t>(); edges > 0)
    text += fmt::format(
        "  {} edges of the scan that turn by more than {:.4g} degrees stay sharp, with {} "
        "corners\n",
        format_count(edges), report["feature_angle"].get<double>(),
        number_text(report["crease_corners"]));
  const Json& quality = report["base_quality"];
  return text + fmt::format(
                    "  quality of faces: worst {:.2f}, 1 % below {:.2f}, median {:.2f}; largest "
                    "valence {}\n",
                    quality["least"].get<double>(), quality["percentile_1"].get<double>(),
                    quality["median"].get<double>(),
                    report["largest_valence"].get<std::uint64_t>());
}

std::string remesh_text(const Json& report) {
  std::string text = base_text(report);
  text += fmt::format(
      "level {}: {} vertices, {} faces, {} of them turned over ({} before {} vertices moved)\n",
      report["levels"].get<int>(), number_text(report["from_vertices"]),
      number_text(report["from_faces"]), number_text(report["turned_faces"]),
      number_text(report["turned_faces_before"]), number_text(report["moved_vertices"]));
  if (!report["depths"].empty())
    text += fmt::format(
        "  depths of their own leave {} of {} vertices, {:.1f} %, and {} of {} faces (--depth "
        "uniform: all)\n",
        number_text(report["vertices"]), number_text(report["from_vertices"]),
        100 * report["vertex_share"].get<double>(), number_text(report["faces"]),
        number_text(report["from_faces"]));
  text += fmt::format("  {} edges folded over 150 degrees (the scan: {})\n",
                      number_text(report["folded_edges"]),
                      number_text(report["scan_figures"]["folded_edges"]));
  if (report.contains("crossing_faces"))
    text += fmt::format("  {} faces pass through others (the scan: {})\n",
                        number_text(report["crossing_faces"]),
                        number_text(report["scan_crossing_faces"]));
  text += fmt::format(
      "  areas of small faces within a base face, 99th percentile to 1st: at most {:.1f} in 90 % "
      "of "
      "the base faces, at most 4 in {:.1f} %\n",
      report["area_spread"]["percentile_90"].get<double>(),
      100 * report["area_spread"]["share_within_4"].get<double>());
  std::vector<std::string> names;
  for (const Json& attribute : report["attributes"])
    names.push_back(attribute["name"].get<std::string>());
  if (!names.empty()) text += fmt::format("attributes of the scan: {}\n", fmt::join(names, ", "));
  for (const Json& attribute : report["face_attributes"])
    text += fmt::format(
        "face attribute {} of the scan: {} of {} base faces have more than one number of it\n",
        attribute["name"].get<std::string>(), number_text(attribute["mixed_faces"]),
        number_text(report["base_figures"]["faces"]));
  if (report.contains("scan_to_store")) {
    const auto diagonal = report["diagonal"].get<double>();
    const auto mean_edge = report["mean_edge"].get<double>();
    text += distances_text("scan to store", report["scan_to_store"], diagonal, mean_edge);
    text += distances_text("store to scan", report["store_to_scan"], diagonal, mean_edge);
  }
  if (report.contains("max_error"))
    for (const auto& [name, rounding] : report["max_error"].items())
      text += fmt::format("{}: {}\n", name, rounding_text(rounding));
  text += fmt::format("{}: {}, {}, {:.2f} s\n", report["store"].get<std::string>(),
                      report["backend"].get<std::string>(),
                      format_bytes(report["stored_bytes"].get<std::uint64_t>()),
                      report["seconds"].get<double>());
  if (report.contains("digest")) text += report["digest"].get<std::string>() + "\n";
  return text;
}

}  // namespace

void add_remesh_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"remesh",
       backend_help(context.backends) + compression_help() +
           "\n"
           "remesh repairs the scan and says how (plait check says it beforehand), collapses edges "
           "until\n"
           "--faces are left, and puts each vertex of the levels on the scan. Genus, components "
           "and\n"
           "borders stay, and so do sharp edges (--feature-angle); if they keep more than 1.05 "
           "times\n"
           "--faces, the command says how many and makes nothing. One percent of the scan's faces "
           "and\n"
           "three levels give about two thirds of its vertices.\n"
           "The scan has to fit in memory, at about 200 bytes a face. Small faces that "
           "stay\n"
           "turned over are counted; attribute \"turned\" is 1 at their corners. With "
           "--no-foldover, "
           "that "
           "part\n"
           "of the scan gets more of the base faces until none is turned. Vertex attributes of a "
           "PLY "
           "file\n"
           "come along: numbers with fractions and colours are interpolated, other integers are "
           "those "
           "of\n"
           "the nearest vertex. Numbers of its faces become face attributes: the mean of each base "
           "face, or\n"
           "of integers the one that covers most of it.\n"
           "--max-error 1e-5 rounds positions, those of the base mesh too, so that no coordinate "
           "changes\n"
           "by more than 1e-5, and 1e-6rel by more than a millionth of the diagonal; the report is "
           "of rounded\n"
           "ones.\n"
           "With --max-distance each face keeps its levels up to a depth of its own, as with plait "
           "prune,\n"
           "and what is drawn is measured against the scan; --depth uniform keeps all levels.\n"
           "\n"
           "Examples:\n"
           "  plait remesh scan.ply scan.plait --faces 10000\n"
           "  plait remesh scan.ply scan.plait --max-distance 0.05%\n"
           "  plait remesh scan.ply scan.plait --faces 5000 --levels 4 --min-component 100 "
           "--fill-holes "
           "50\n"
           "  plait remesh scan.ply scan.plait --faces 10000 --no-foldover --json\n"
           "  plait remesh scan.ply small.plait --faces 10000 --compress small --max-error "
           "1e-5rel\n"
           "  plait compare scan.ply scan.plait\n"
           "  plait remesh scan.ply scan.plait --faces 10000 --distances --force\n"
           "  plait render scan.plait distance.png --color-by distance",
       remesh_text});
}

}  // namespace plait
