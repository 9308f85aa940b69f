#include "paper/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "argument_text.h"
#include "instrument/environment.h"
#include "instrument/process.h"
#include "interrupt.h"
#include "io/partial_output.h"
#include "paper/paper_way.h"
#include "paper/pictures.h"
#include "paper/tables.h"
#include "picture/png_file.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "plait/subdivide.h"
#include "plait/version.h"

namespace plait::paper {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::uint64_t kFewestBudgetBytes = std::uint64_t{64} << 20;
constexpr int kSurfaceLevel = 3;
constexpr std::size_t kSpanPictureWidth = 1300;

const Model& model_of(const ReportRequest& request, std::size_t at) {
  return model_from_name(request.models[at]);
}
int levels_of(const ReportRequest& request, const Model& model) {
  return request.levels != 0 ? request.levels : model.levels;
}

void check(const ReportRequest& request) {
  for (std::size_t at = 0; at < request.models.size(); ++at) (void)model_of(request, at);
  if (request.models.size() != 1 && (!request.mesh.empty() || request.vertices != 0))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("paper: a mesh of one's own stands for one model, found {} models",
                            request.models.size()));
  if (!request.mesh.empty() && request.vertices != 0)
    throw Error(ErrorCode::kInvalidArgument,
                "paper: expected a mesh or a number of vertices, found both");
  for (const std::string& executor : request.executors)
    if (executor != kPaperWay) (void)executor_from_name(executor);
}

std::vector<std::string> backends_of(const ReportRequest& request,
                                     const BackendRegistry& registry) {
  if (!request.backends.empty()) {
    for (const std::string& backend : request.backends) (void)registry.find(backend);
    return request.backends;
  }
  return registry.names();
}

std::vector<PlannedRun> runs_of(const ReportRequest& request, const Model& model,
                                std::uint64_t loop_span, const BackendRegistry& registry) {
  if (!request.runs) return {};
  const std::uint64_t buffers = circular_buffer_bytes(loop_span, levels_of(request, model));
  std::vector<std::uint64_t> budgets = request.budgets;
  if (budgets.empty()) {
    constexpr std::uint64_t kMebibyte = 1 << 20;
    budgets = {std::max(kFewestBudgetBytes, (buffers + kMebibyte - 1) / kMebibyte * kMebibyte)};
    if (model.elapsed.size() == 2) budgets.push_back(4 * budgets[0]);
  }
  return plan_runs(request.executors, backends_of(request, registry), budgets, buffers, registry);
}

Json paper_figures(const Model& model) {
  return {{"vertices", model.vertices},
          {"edges", model.edges},
          {"levels", model.levels},
          {"face_span", model.face_span},
          {"loop_span", model.loop_span},
          {"elapsed", model.elapsed},
          {"memory_bytes", model.memory_bytes},
          {"processor_seconds", model.processor_seconds},
          {"disk_bytes", model.disk_bytes}};
}

/// The work on one mesh, in child processes.
class ModelReport {
 public:
  ModelReport(const ReportRequest& request, const Model& model, const BackendRegistry& registry,
              const StepProgress& progress, const fs::path& scratch)
      : request_(request),
        model_(model),
        registry_(registry),
        progress_(progress),
        scratch_(scratch),
        levels_(levels_of(request, model)) {}

  /// Fills `json` step by step, so that it has what was done if a step throws.
  void make(Json& json) {
    const bool stand_in = request_.mesh.empty();
    json = {{"name", model_.name},
            {"title", model_.title},
            {"source", stand_in ? describe_stand_in(model_, request_.vertices)
                                : request_.mesh.filename().string()},
            {"is_stand_in", stand_in},
            {"levels", levels_},
            {"paper", paper_figures(model_)},
            {"tables", nullptr},
            {"runs", Json::array()},
            {"digests_equal", nullptr},
            {"digest", nullptr},
            {"pictures", Json::array()}};
    const fs::path mesh = stand_in ? scratch_ / "mesh.ply" : request_.mesh;
    step("base mesh");
    if (stand_in)
      in_child([&] {
        write_ply(mesh, make_stand_in(model_, request_.vertices));
        return nlohmann::json();
      });
    step("counts and spans");
    json["tables"] = in_child([&] { return mesh_tables(read_base_mesh(mesh), levels_); });
    if (!request_.pictures_directory.empty()) draw(json, mesh);
    run(json, mesh);
  }

 private:
  void step(const std::string& name) {
    throw_if_interrupted();
    progress_(0, 0, fmt::format("{}: {}", model_.name, name));
  }

  template <class Work>
  static nlohmann::json in_child(Work work) {
    try {
      return instrument::in_own_process(work);
    } catch (const Error&) {
      throw_if_interrupted();  // Ctrl-C also ends the child
      throw;
    }
  }

  void run(Json& json, const fs::path& mesh) {
    std::uint64_t span = 0;
    for (const Json& row : json["tables"]["spans"])
      if (row["layout"] == "spatial") span = row["loop"];
    const std::vector<PlannedRun> runs = runs_of(request_, model_, span, registry_);
    if (runs.empty()) return;
    instrument::require_space(request_.directory,
                              store_bytes(json["tables"]["counts"].back().get<std::uint64_t>()));
    const RunSettings settings{.mesh = mesh,
                               .scratch = scratch_,
                               .levels = levels_,
                               .threads = request_.threads,
                               .limit_bytes = request_.limit_bytes};
    for (std::size_t at = 0; at < runs.size(); ++at) {
      progress_(at, runs.size(),
                fmt::format("{}: {} on {}", model_.name, runs[at].executor, runs[at].backend));
      const Json row = Json(carry_out(settings, runs[at], registry_));
      json["runs"].push_back(row);
      if (!row.contains("digest")) continue;
      if (json["digest"].is_null()) {
        json["digest"] = row["digest"];
        json["digests_equal"] = true;
      }
      if (row["digest"] != json["digest"]) json["digests_equal"] = false;
    }
  }

  void draw(Json& json, const fs::path& mesh) {
    step("pictures");
    const auto add = [&](const std::string& name, const std::string& caption, auto make) {
      throw_if_interrupted();
      PartialFile file(request_.pictures_directory / name, Existing::kReplace);
      in_child([&] {
        write_png(make(read_base_mesh(mesh)), file.file());
        return nlohmann::json();
      });
      file.publish();
      json["pictures"].push_back(
          {{"file", (request_.pictures_directory / name).string()}, {"caption", caption}});
    };
    const int level = std::min(levels_, kSurfaceLevel);
    add(fmt::format("paper-{}-surface.png", model_.name),
        fmt::format("As Figure 5: the base mesh, and its Loop surface at level {}.", level),
        [&](const BaseMesh& base) { return surface_picture(base, level, request_.threads); });
    for (const LayoutKind order : {LayoutKind::kGiven, LayoutKind::kSpatial})
      add(fmt::format("paper-{}-spans-{}.png", model_.name, to_string(order)),
          fmt::format("As Figures 6 and 7: stencils of faces (left) and of Loop (right) over edge "
                      "indices, {} ordering.",
                      order == LayoutKind::kGiven ? "before" : "after the paper's"),
          [&](const BaseMesh& base) { return span_picture(base, order, kSpanPictureWidth); });
  }

  const ReportRequest& request_;
  const Model& model_;
  const BackendRegistry& registry_;
  const StepProgress& progress_;
  const fs::path& scratch_;
  int levels_;
};

}  // namespace

Json make_report(const ReportRequest& request, const BackendRegistry& registry,
                 const StepProgress& progress, const fs::path& scratch) {
  check(request);
  const Json environment = instrument::environment(instrument::disk_facts(request.directory));
  Json report = {{"plait", std::string("plait ") + PLAIT_VERSION},
                 {"date", instrument::date_text()},
                 {"machine", instrument::machine_text(environment)},
                 {"environment", environment},
                 {"command", command_text()},
                 {"interrupted", false},
                 {"failed", false},
                 {"models", Json::array()}};
  for (std::size_t at = 0; at < request.models.size() && !report["interrupted"].get<bool>(); ++at) {
    Json& model = report["models"].emplace_back();
    try {
      ModelReport(request, model_of(request, at), registry, progress, scratch).make(model);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCancelled) throw;
      report["interrupted"] = true;
    }
    if (model.contains("digests_equal") && model["digests_equal"] == false) report["failed"] = true;
    // Nothing can be said of a mesh without its tables.
    if (model["tables"].is_null()) report["models"].erase(report["models"].size() - 1);
  }
  return report;
}

}  // namespace plait::paper
