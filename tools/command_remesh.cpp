// plait remesh: makes a store from a scan.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "progress.h"
#include "remesh/remesh.h"
#include "scan_report.h"

namespace plait {
namespace {

std::string limits_text(const RemeshRequest& request, const RemeshReport& report) {
  if (report.base.faces <= request.faces + 1) return {};
  return fmt::format(
      "  more than the {} faces asked for: {} edges are kept by genus, borders or components, {} "
      "by "
      "the shape of faces\n",
      format_count(request.faces), format_count(report.kept_by_topology),
      format_count(report.kept_by_shape));
}

void print_report(const RemeshRequest& request, const RemeshReport& report) {
  std::string text = fmt::format("{}: {}\n", request.scan.native(), figures_text(report.scan));
  if (!report.repairs.is_clean()) text += "repaired:\n" + repair_text(report.repairs);
  text += fmt::format("base mesh: {}\n", figures_text(report.base));
  if (report.base_meshes > 1)
    text += fmt::format("  made {} times, until no small face was turned over\n",
                        format_count(report.base_meshes));
  text += limits_text(request, report);
  text += fmt::format(
      "  quality of faces: worst {:.2f}, 1 % below {:.2f}, median {:.2f}; largest valence {}\n",
      report.shape.least_quality, report.shape.percentile_1_quality, report.shape.median_quality,
      report.shape.largest_valence);
  text += fmt::format(
      "level {}: {} vertices, {} faces, {} of them turned over ({} before {} vertices moved)\n",
      request.levels, format_count(report.vertices), format_count(report.small_faces),
      format_count(report.turned), format_count(report.turned_before),
      format_count(report.moved_samples));
  text += fmt::format(
      "  areas of small faces within a base face, 99th percentile to 1st: at most {:.1f} in 90 % "
      "of "
      "the base faces, at most 4 in {:.1f} %\n",
      report.area_spread.percentile_90, 100 * report.area_spread.share_within_4);
  if (!report.attributes.empty()) {
    std::vector<std::string> names;
    for (const AttributeSchema& schema : report.attributes) names.push_back(schema.name);
    text += fmt::format("attributes of the scan: {}\n", fmt::join(names, ", "));
  }
  if (request.report_samples > 0) {
    text += distances_text("scan to store", report.to_store, report.diagonal, report.mean_edge);
    text += distances_text("store to scan", report.to_scan, report.diagonal, report.mean_edge);
  }
  text += fmt::format("{}: {}, {}, {:.2f} s\n", request.store.native(), report.backend,
                      format_bytes(report.stored_bytes), seconds_since_start());
  if (!report.digest.empty()) text += report.digest + "\n";
  print(text);
}

nlohmann::ordered_json report_json(const RemeshRequest& request, const RemeshReport& report) {
  nlohmann::ordered_json json = {{"scan", request.scan.string()},
                                 {"store", request.store.string()},
                                 {"merged_vertices", report.merged_vertices},
                                 {"seam_vertices", report.seam_vertices},
                                 {"precision", to_string(report.precision)},
                                 {"repairs", repair_json(report.repairs)},
                                 {"scan_figures", figures_json(report.scan)},
                                 {"base_figures", figures_json(report.base)},
                                 {"faces_asked", request.faces},
                                 {"edges_kept_by_topology", report.kept_by_topology},
                                 {"edges_kept_by_shape", report.kept_by_shape},
                                 {"base_quality",
                                  {{"least", report.shape.least_quality},
                                   {"percentile_1", report.shape.percentile_1_quality},
                                   {"median", report.shape.median_quality}}},
                                 {"largest_valence", report.shape.largest_valence},
                                 {"base_meshes", report.base_meshes},
                                 {"levels", request.levels},
                                 {"vertices", report.vertices},
                                 {"faces", report.small_faces},
                                 {"relaxed_vertices", report.relaxed_samples},
                                 {"turned_faces_before", report.turned_before},
                                 {"turned_faces", report.turned},
                                 {"moved_vertices", report.moved_samples},
                                 {"area_spread",
                                  {{"percentile_90", report.area_spread.percentile_90},
                                   {"share_within_4", report.area_spread.share_within_4}}},
                                 {"diagonal", report.diagonal},
                                 {"mean_edge", report.mean_edge}};
  if (request.report_samples > 0) {
    json["scan_to_store"] = distances_json(report.to_store, report.diagonal);
    json["store_to_scan"] = distances_json(report.to_scan, report.diagonal);
  }
  json["attributes"] = nlohmann::ordered_json::array();
  for (const AttributeSchema& schema : report.attributes)
    json["attributes"].push_back({{"name", schema.name},
                                  {"type", to_string(schema.type)},
                                  {"components", schema.components}});
  json["backend"] = report.backend;
  json["stored_bytes"] = report.stored_bytes;
  json["threads"] = request.threads;
  json["read_seconds"] = report.read_seconds;
  json["repair_seconds"] = report.repair_seconds;
  json["decimate_seconds"] = report.decimate_seconds;
  json["sample_seconds"] = report.sample_seconds;
  json["relax_seconds"] = report.relax_seconds;
  json["untangle_seconds"] = report.untangle_seconds;
  json["write_seconds"] = report.write_seconds;
  json["report_seconds"] = report.report_seconds;
  json["seconds"] = seconds_since_start();
  json["cpu_seconds"] = cpu_seconds();
  json["peak_rss_bytes"] = peak_rss_bytes();
  if (!report.digest.empty()) json["digest"] = report.digest;
  return json;
}

int run_remesh(const RemeshRequest& request, const CommandContext& context) {
  RemeshReport report;
  {
    ProgressBar progress("remesh", ProgressUnit::kNone);
    report = remesh(
        request, context.backends,
        {.progress =
             [&](const Progress& now) { return progress.update(now.done, now.total, now.phase); },
         .warn =
             [&](const std::string& what) {
               progress.clear();
               report_warning(what);
             }});
  }
  if (context.json)
    print(json_text(report_json(request, report)));
  else
    print_report(request, report);
  return kExitDone;
}

}  // namespace

void add_remesh_command(CommandLine& program, CommandContext& context) {
  const auto request = std::make_shared<RemeshRequest>();
  request->threads = default_thread_count();
  CommandLine* command =
      program.add_subcommand("remesh", "Make a store from a scan: any triangle mesh");
  command->add_option("SCAN", request->scan, "PLY, OBJ, OFF or STL, also .gz and .zst")->required();
  add_output_option(*command, "OUT", request->store, "The store to make: NAME.plait")->required();
  add_whole_option(*command, "--faces", request->faces, 1, std::uint64_t{1} << 30,
                   "Faces of the base mesh, at most")
      ->required();
  add_whole_option(*command, "--levels", request->levels, 1, 12, "The finest level")
      ->default_str("3");
  add_whole_option(*command, "--min-component", request->repair.min_component, 0,
                   std::uint64_t{1} << 32, "Remove components of fewer faces")
      ->default_str("0");
  add_whole_option(*command, "--fill-holes", request->repair.fill_holes, 0, std::uint64_t{1} << 32,
                   "Fill holes of at most so many edges")
      ->default_str("0");
  add_precision_option(*command, request->precision,
                       "Type of the positions: float32, float64 or auto: float32, unless it moves "
                       "a vertex of SCAN by more than a thousandth of the shortest edge there");
  add_weld_option(*command, request->weld);
  command->add_flag("--no-foldover", request->refuse_turned,
                    "Make the base mesh anew, at most 8 times, while small faces are turned over; "
                    "refuse what is left");
  command->add_flag("--distances", request->distances,
                    "Add attribute distance: how far the scan is from the store");
  add_whole_option(*command, "--samples", request->report_samples, 0, 1000000000,
                   "Points of the report in each direction; 0 for no distances")
      ->default_str("1000000");
  command->add_option("--backend", request->options.backend, "How the store keeps its blocks")
      ->capture_default_str();
  add_size_option(*command, "--memory", request->options.budget_bytes,
                  "Budget for blocks in memory");
  add_threads_option(*command, request->threads, "Worker threads");
  command->add_flag("--force", request->replace, "Replace a store of this name");
  command->add_flag("--ignore-size", request->ignore_size, "Start even if the memory is too small");
  command->add_flag("--digest", request->digest, "Print the digest, which covers every vertex");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) +
      "\n"
      "remesh repairs the scan and says how (plait check says it beforehand), collapses edges "
      "until\n"
      "--faces are left, and puts each vertex of the levels on the scan. Genus, components and\n"
      "borders stay. One percent of the scan's faces and three levels give about two thirds of "
      "its\n"
      "vertices. The scan has to fit in memory, at about 200 bytes a face. Small faces that stay\n"
      "turned over are counted; attribute \"turned\" marks their corners. With --no-foldover, that "
      "part\n"
      "of the scan gets more of the base faces until none is turned. Vertex attributes of a PLY "
      "file\n"
      "come along: numbers with fractions and colours are interpolated, other integers are those "
      "of\n"
      "the nearest vertex. plait convert compresses the store.\n"
      "\n"
      "Examples:\n"
      "  plait remesh scan.ply scan.plait --faces 10000\n"
      "  plait remesh scan.ply scan.plait --faces 5000 --levels 4 --min-component 100 --fill-holes "
      "50\n"
      "  plait remesh scan.ply scan.plait --faces 10000 --no-foldover --json\n"
      "  plait compare scan.ply scan.plait\n"
      "  plait remesh scan.ply scan.plait --faces 10000 --distances --force\n"
      "  plait render scan.plait distance.png --color-by distance");
  command->callback([request, &context] {
    context.run = [request, &context] { return run_remesh(*request, context); };
  });
}

}  // namespace plait
