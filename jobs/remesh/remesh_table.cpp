// The job "remesh".
#include <fmt/format.h>

#include "job.h"
#include "job_rules.h"
#include "remesh/remesh.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kNoFeature = 180;  ///< degrees that no edge exceeds

struct RemeshArguments : RemeshRequest {
  std::vector<std::string> compress, max_error_texts;
};

/// Of "position" alone: the other attributes come from the file as they are.
std::optional<ErrorBound> bound_of_positions(const ErrorBounds& bounds) {
  for (const auto& [name, bound] : bounds.all())
    if (name != "position")
      throw JobError(ErrorCode::kInvalidArgument,
                     fmt::format("remesh: expected a bound of 'position', found one of '{}', which "
                                 "plait convert rounds in the store",
                                 name),
                     "max-error");
  return bounds.of("position");
}

JobReport run_remesh(RemeshArguments& request, const JobCall& call) {
  request.max_error = bound_of_positions(error_bounds_of(request.max_error_texts));
  request.options.pipeline_of =
      pipelines_of(compression_of(request.compress), request.max_error.has_value(),
                   request.options.backend, call.backends);
  request.options.parallel_for = call.parallel_for;
  const RemeshReport report = remesh(request, call.backends, call.watch);
  warn_of_unknown_attributes(request.compress, {"position", "turned", "distance"},
                             report.attributes, call.watch);
  JobReport json = {{"scan", request.scan.string()},
                    {"store", request.store.string()},
                    {"repairs", repairs_json(report.repairs)},
                    {"scan_figures", figures_json(report.scan)},
                    {"base_figures", figures_json(report.base)},
                    {"faces_asked", report.faces_asked},
                    {"max_distance", report.max_distance},
                    {"trials", report.trials},
                    {"edges_kept_by_topology", report.kept_by_topology},
                    {"edges_kept_by_shape", report.kept_by_shape},
                    {"base_quality",
                     {{"least", report.shape.least_quality},
                      {"percentile_1", report.shape.percentile_1_quality},
                      {"median", report.shape.median_quality}}},
                    {"largest_valence", report.shape.largest_valence},
                    {"base_meshes", report.base_meshes},
                    {"levels", report.levels},
                    {"vertices", report.vertices},
                    {"faces", report.small_faces},
                    {"from_vertices", report.from_vertices},
                    {"from_faces", report.from_faces},
                    {"vertex_share", static_cast<double>(report.vertices) /
                                         static_cast<double>(report.from_vertices)},
                    {"depths", depths_json(report.faces_of_level)},
                    {"depth_trials", report.depth_trials},
                    {"feature_angle", report.feature_angle},
                    {"crease_edges", report.crease_edges},
                    {"crease_corners", report.crease_corners},
                    {"faces_for_creases", report.faces_for_creases},
                    {"exact_base_faces", report.exact_faces},
                    {"relaxed_vertices", report.relaxed_samples},
                    {"turned_faces_before", report.turned_before},
                    {"turned_faces", report.turned},
                    {"folded_edges", report.folds},
                    {"moved_vertices", report.moved_samples},
                    {"area_spread",
                     {{"percentile_90", report.area_spread.percentile_90},
                      {"share_within_4", report.area_spread.share_within_4}}},
                    {"merged_vertices", report.merged_vertices},
                    {"seam_vertices", report.seam_vertices},
                    {"precision", to_string(report.precision)},
                    {"lost_step", report.lost_step},
                    {"diagonal", report.diagonal},
                    {"mean_edge", report.mean_edge}};
  if (request.report_samples > 0) {
    json["scan_to_store"] = distances_json(report.to_store, report.diagonal);
    json["crossing_faces"] = report.crossings.faces;
    json["scan_crossing_faces"] = report.scan_crossings.faces;
    json["faces_looked_at"] = report.crossings.examined;
    json["scan_faces_looked_at"] = report.scan_crossings.examined;
    json["far_share"] = report.to_store.far_share;
    json["far_places"] = JobReport::array();
    for (const FarPlace& place : report.to_store.far_places)
      json["far_places"].push_back({{"position", {place.at.x, place.at.y, place.at.z}},
                                    {"distance", place.distance},
                                    {"share", place.share}});
    json["store_to_scan"] = distances_json(report.to_scan, report.diagonal);
  }
  json["attributes"] = attributes_json(report.attributes);
  json["face_attributes"] = attributes_json(report.face_attributes);
  for (std::size_t at = 0; at < report.mixed_faces.size(); ++at)
    json["face_attributes"][at]["mixed_faces"] = report.mixed_faces[at];
  if (report.rounding) json["max_error"]["position"] = rounding_json(*report.rounding);
  json["backend"] = report.backend;
  json["stored_bytes"] = report.stored_bytes;
  json["threads"] = request.threads;
  json["read_seconds"] = report.read_seconds;
  json["repair_seconds"] = report.repair_seconds;
  json["decimate_seconds"] = report.decimate_seconds;
  json["sample_seconds"] = report.sample_seconds;
  json["relax_seconds"] = report.relax_seconds;
  json["untangle_seconds"] = report.untangle_seconds;
  json["prune_seconds"] = report.prune_seconds;
  json["write_seconds"] = report.write_seconds;
  json["report_seconds"] = report.report_seconds;
  if (!report.digest.empty()) json["digest"] = report.digest;
  return json;
}

}  // namespace

Job remesh_job() {
  JobTable<RemeshArguments> table("remesh", "Make a store from a scan: any triangle mesh");
  table.path("input", &RemeshArguments::scan, "PLY, OBJ, OFF or STL, also .gz and .zst")
      .at(0)
      .required();
  table.output("output", &RemeshArguments::store, "The store to make: NAME.plait").at(1).required();
  table.count("faces", &RemeshArguments::faces, 1, std::uint64_t{1} << 30,
              "Faces of the base mesh, at most; with --max-distance, of the first that is tried");
  table.count("levels", &RemeshArguments::levels, 1, 12,
              "The finest level; with --max-distance, at most");
  table
      .named(
          "max-distance",
          [](RemeshRequest& request, const std::string& text) {
            request.max_distance = parse_relative_length(text);
          },
          "Take as many faces as bring every point of the report so near, in units of INPUT or in "
          "percent of its diagonal")
      .shown_as("D[%]");
  table.choice(
      "depth", {"own", "uniform"},
      [](RemeshRequest& request, const std::string& name) { request.own_depths = name == "own"; },
      "Each face has a depth of its own, with which it is still within --max-distance (then the "
      "default), or all levels");
  table.count(
      "min-component",
      [](RemeshArguments & request) -> auto& { return request.repair.min_component; }, 0,
      std::uint64_t{1} << 32, "Remove components of fewer faces");
  table.count(
      "fill-holes", [](RemeshArguments & request) -> auto& { return request.repair.fill_holes; }, 0,
      std::uint64_t{1} << 32, "Fill holes with at most this number of edges");
  table
      .named(
          "feature-angle",
          [](RemeshRequest& request, const std::string& text) {
            if (text == "auto")
              request.feature_angle.reset();
            else
              request.feature_angle =
                  text == "none" ? kNoFeature : parse_number(text, 1, kNoFeature);
          },
          "Edges that turn by more degrees stay sharp; auto: chosen from the angles of INPUT")
      .by_default("auto")
      .shown_as("DEGREES|auto|none");
  table.flag("no-foldover", &RemeshArguments::refuse_turned,
             "Make the base mesh anew, at most 8 times, while small faces are turned over; refuse "
             "what is left");
  table.flag("distances", &RemeshArguments::distances,
             "Add attribute distance: how far the scan is from the store");
  table.count("samples", &RemeshArguments::report_samples, 0, 1000000000,
              "Points of the report in each direction; 0 for no distances");
  table.precision(&RemeshArguments::precision,
                  "Type of the positions; auto: float32, unless it moves a vertex of INPUT by more "
                  "than a thousandth of the shortest edge there");
  table.weld(&RemeshArguments::weld);
  table.text(
      "backend", [](RemeshArguments & request) -> auto& { return request.options.backend; },
      "The backend that stores the levels (see below)");
  table.compress(&RemeshArguments::compress);
  table.max_error(&RemeshArguments::max_error_texts);
  table.bytes(
      "memory", [](RemeshArguments & request) -> auto& { return request.options.budget_bytes; },
      "Budget for blocks in memory");
  table.threads(&RemeshArguments::threads, "Worker threads");
  table.flag("digest", &RemeshArguments::digest, "Print the digest, which covers every vertex");
  table.force(&RemeshArguments::existing);
  table.flag("ignore-size", &RemeshArguments::ignore_size, "Start even if the memory is too small")
      .remedy("starts anyway");
  return table.run(run_remesh);
}

PLAIT_END_NAMESPACE
