#include "paper/report.h"

#include <fmt/format.h>

#include "argument_text.h"
#include "instrument/environment.h"
#include "instrument/process.h"
#include "interrupt.h"
#include "io/unpublished.h"
#include "paper/mesh_figures.h"
#include "picture/png_file.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/subdivide.h"
#include "plait/version.h"

namespace plait::paper {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::uint64_t kVertexBytes = 24;  // position and normal, float32
constexpr std::size_t kSpanPictureWidth = 1300;

void check(const ReportRequest& request, const BackendRegistry& registry) {
  for (const std::string& model : request.models) (void)model_from_name(model);
  for (const std::string& backend : request.backends) (void)registry.find(backend);
  for (const std::string& executor : request.executors)
    if (executor != kPaperWay) (void)executor_from_name(executor);
  if (request.models.size() != 1 && (!request.mesh.empty() || request.vertices != 0))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("paper: a mesh of one's own stands for one model, found {} models",
                            request.models.size()));
  if (!request.mesh.empty() && request.vertices != 0)
    throw Error(ErrorCode::kInvalidArgument,
                "paper: expected a mesh or a number of vertices, found both");
}

template <class Work>
nlohmann::json in_child(Work work) {
  try {
    return instrument::in_own_process(work);
  } catch (const Error&) {
    throw_if_interrupted();  // Ctrl-C also ends the child
    throw;
  }
}

/// The work on one mesh, in child processes.
struct ModelReport {
  ReportRequest request;
  const Model& model;
  const BackendRegistry& registry;
  const StepProgress& progress;
  const fs::path& scratch;

  /// Fills `report` step by step, so that it has what was done if a step throws.
  void make(Json& report) {
    const bool stand_in = request.mesh.empty();
    if (request.levels == 0) request.levels = model.levels;
    report = {{"name", model.name},
              {"source", stand_in ? describe_stand_in(model, request.vertices)
                                  : request.mesh.filename().string()},
              {"is_stand_in", stand_in},
              {"levels", request.levels},
              {"tables", nullptr},
              {"runs", Json::array()},
              {"digests_equal", nullptr},
              {"digest", nullptr},
              {"pictures", Json::array()}};
    step("base mesh");
    if (stand_in) {
      request.mesh = scratch / "mesh.ply";
      in_child([&] {
        write_ply(request.mesh, make_stand_in(model, request.vertices));
        return nlohmann::json();
      });
    }
    step("counts and spans");
    report["tables"] =
        in_child([&] { return mesh_tables(read_base_mesh(request.mesh), request.levels); });
    if (!request.pictures_directory.empty()) draw(report["pictures"]);
    if (request.runs) run(report);
  }

  void step(const std::string& name, std::size_t done = 0, std::size_t total = 0) const {
    throw_if_interrupted();
    progress(done, total, fmt::format("{}: {}", model.name, name));
  }

  void run(Json& report) const {
    std::uint64_t span = 0;
    for (const Json& row : report["tables"]["spans"])
      if (row["layout"] == "spatial") span = row["loop"];
    const std::uint64_t vertices = report["tables"]["shares"].back()["vertices"];
    const std::uint64_t records = vertices * kVertexBytes;
    // With a twentieth for the store's other files.
    instrument::require_space(request.directory, records + records / 20 + (std::uint64_t{4} << 20));
    const std::vector<PlannedRun> runs = plan_runs(request, model, span, registry);
    for (std::size_t at = 0; at < runs.size(); ++at) {
      step(fmt::format("{} on {}", runs[at].executor, runs[at].backend), at, runs.size());
      const Json row = Json(carry_out(request, scratch, runs[at], registry));
      report["runs"].push_back(row);
      if (!row.contains("digest")) continue;
      if (report["digest"].is_null()) {
        report["digest"] = row["digest"];
        report["digests_equal"] = true;
      }
      if (row["digest"] != report["digest"]) report["digests_equal"] = false;
    }
  }

  void draw(Json& pictures) const {
    for (const LayoutKind order : {LayoutKind::kGiven, LayoutKind::kSpatial}) {
      step("pictures");
      const fs::path path = request.pictures_directory /
                            fmt::format("paper-{}-spans-{}.png", model.name, to_string(order));
      UnpublishedFile file(path, Existing::kReplace);
      file.file();  // in this process
      in_child([&] {
        write_png(span_picture(read_base_mesh(request.mesh), order, kSpanPictureWidth),
                  file.file());
        return nlohmann::json();
      });
      file.publish();
      pictures.push_back(
          {{"file", path.string()},
           {"caption", fmt::format("As Figures 6 and 7: stencils of faces (left) and of Loop "
                                   "(right) over edge indices, {} ordering.",
                                   order == LayoutKind::kGiven ? "before" : "after the paper's")}});
    }
  }
};

}  // namespace

Json make_report(const ReportRequest& request, const BackendRegistry& registry,
                 const StepProgress& progress, const fs::path& scratch) {
  check(request, registry);
  const Json environment = instrument::environment(instrument::disk_facts(request.directory));
  Json report = {{"plait", std::string("plait ") + PLAIT_VERSION},
                 {"date", instrument::date_text()},
                 {"machine", instrument::machine_text(environment)},
                 {"environment", environment},
                 {"command", command_text()},
                 {"interrupted", false},
                 {"failed", false},
                 {"models", Json::array()}};
  Json& made = report["models"];
  try {
    for (const std::string& name : request.models)
      ModelReport{request, model_from_name(name), registry, progress, scratch}.make(
          made.emplace_back());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled) throw;
    report["interrupted"] = true;
  }
  // Nothing can be said of a mesh without its tables.
  if (!made.empty() && made.back()["tables"].is_null()) made.erase(made.size() - 1);
  for (const Json& model : made)
    if (model["digests_equal"] == false) report["failed"] = true;
  return report;
}

}  // namespace plait::paper
