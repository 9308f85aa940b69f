// The job "check".
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "job.h"
#include "mesh/weld.h"
#include "plait/extend/attributed_mesh.h"
#include "report_json.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct CheckRequest {
  std::filesystem::path mesh;
  std::optional<double> weld;
};

JobReport check(const CheckRequest& request, const JobCall& call) {
  std::vector<std::string> warnings;
  AttributedMesh mesh =
      read_attributed_mesh(request.mesh, &warnings, NotFinite::kKeep, OfFaces::kKeep);
  std::uint64_t merged = 0;
  if (request.weld) merged = weld(mesh, *request.weld, request.mesh.native(), warnings);
  if (call.watch.warn)
    for (const std::string& warning : warnings) call.watch.warn(warning);
  const Repaired repaired = repair(std::move(mesh.mesh), {}, request.mesh.native());
  return {{"mesh", request.mesh.string()},
          {"merged_vertices", merged},
          {"seam_vertices", repaired.seam_vertices},
          {"found", repairs_json(repaired.list)},
          {"repaired", figures_json(figures_of(repaired.surface))}};
}

}  // namespace

Job check_job() {
  JobTable<CheckRequest> table("check", "Say what is wrong with a mesh, without changing it");
  table.path("mesh", &CheckRequest::mesh, "PLY, OBJ, OFF or STL, also .gz and .zst")
      .at(0)
      .required();
  table.weld(&CheckRequest::weld);
  return table.run([](CheckRequest& request, const JobCall& call) { return check(request, call); });
}

PLAIT_END_NAMESPACE
