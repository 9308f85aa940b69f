#include "remesh/read_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "export/crease_normals.h"
#include "import/fine_mesh.h"
#include "job_rules.h"
#include "mesh/narrowing.h"
#include "mesh/weld.h"
#include "plait/extend/attributed_mesh.h"
#include "surface/repair.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kBytesPerScanFace = 200;
constexpr std::uint64_t kBytesPerSmallFace = 140;
constexpr std::uint64_t kBytesPerFaceOfAllLevels = 60;  ///< of a store in memory
constexpr std::uint64_t kFacesPerVertex = 2;
constexpr std::string_view kTurned = "turned", kDistance = "distance";

/// How many levels the small faces are finer than those of the scan.
int levels_finer_than(std::uint64_t scan_faces, const RemeshRequest& request) {
  if (request.max_distance) return 1;  // DistanceSearch::levels()
  int levels = 0;
  for (std::uint64_t faces = request.faces << (2 * request.levels); faces > scan_faces; faces /= 4)
    ++levels;
  return levels;
}

/// The store has attributes of its own.
void leave_out_own_names(std::vector<MeshAttribute>& attributes, bool distances,
                         std::vector<std::string>& warnings) {
  std::erase_if(attributes, [&](const MeshAttribute& attribute) {
    const std::string& name = attribute.schema.name;
    if (name != kTurned && !(distances && name == kDistance)) return false;
    warnings.push_back(
        fmt::format("attribute '{}' of the scan left out: the store has its own", name));
    return true;
  });
}

}  // namespace

ScanToSample read_scan(const RemeshRequest& request, const ScanProgress& progress,
                       const JobWatch& watch, RemeshReport& report) {
  ScanToSample scan;
  Stopwatch clock;
  progress.begin("read", 0);
  check_memory_for(request, kFacesPerVertex * expected_vertices(request.scan));
  std::vector<std::string> warnings;
  AttributedMesh mesh =
      read_attributed_mesh(request.scan, &warnings, NotFinite::kKeep, OfFaces::kKeep);
  leave_out_own_names(mesh.attributes, request.distances, warnings);
  std::erase_if(mesh.face_attributes, [&](const MeshAttribute& attribute) {
    if (attribute.schema.name != kCreaseSides) return false;
    warnings.push_back(
        fmt::format("property {} of the faces of the scan left out: it is what the store says of "
                    "its own sharp edges",
                    kCreaseSides));
    return true;
  });
  if (request.weld)
    report.merged_vertices = weld(mesh, *request.weld, request.scan.native(), warnings);
  warn_of_values_not_finite(mesh, warnings);
  report.precision = precision_for(mesh.mesh, levels_finer_than(mesh.mesh.faces.size(), request),
                                   request.precision, {}, request.scan.native(), warnings);
  report.read_seconds = clock.lap();
  check_memory_for(request, mesh.mesh.faces.size());
  const auto go_on = [&] { progress.begin("repair", 0); };
  go_on();
  Repaired repaired = repair(std::move(mesh.mesh), request.repair, request.scan.native());
  go_on();
  report.mean_edge = mean_edge_of({repaired.surface.positions, repaired.surface.faces});
  report.lost_step = lost_step(repaired.surface.positions, report.mean_edge);
  if (report.lost_step > 0)
    warnings.push_back(fmt::format(
        "{}: coordinates have steps of {:.3g}, {:.2g} mean edges, because their other digits were "
        "lost before: write the scan as float64, or relative to a point near it",
        request.scan.native(), report.lost_step, report.lost_step / report.mean_edge));
  report.seam_vertices = repaired.seam_vertices;
  if (repaired.seam_vertices > 0)
    warnings.push_back(fmt::format(
        "{}: {}", request.scan.native(),
        report.lost_step > 0 ? seam_text(repaired.seam_vertices, "the lost digits told them apart")
                             : seam_text(repaired.seam_vertices)));
  if (watch.warn)
    for (const std::string& warning : warnings) watch.warn(warning);
  go_on();
  scan.attributes = ScanAttributes(std::move(mesh.attributes), repaired);
  scan.of_faces =
      ScanFaceAttributes(std::move(mesh.face_attributes), std::move(repaired.face_origin));
  scan.surface = std::move(repaired.surface);
  report.repairs = repaired.list;
  report.scan = figures_of(scan.surface);
  go_on();
  report.diagonal = diagonal_of({scan.surface.positions, scan.surface.faces});
  report.repair_seconds = clock.lap();
  return scan;
}

void check_memory_for(const RemeshRequest& request, std::uint64_t scan_faces) {
  const std::uint64_t base_faces = std::min(request.faces, scan_faces);
  const bool prunes = request.max_distance && request.own_depths.value_or(true);
  const std::uint64_t needed = scan_faces * kBytesPerScanFace +
                               (base_faces << (2 * request.levels)) *
                                   (kBytesPerSmallFace + (prunes ? kBytesPerFaceOfAllLevels : 0)) +
                               request.options.budget_bytes;
  check_memory(fmt::format("remesh {}: {} faces and {} small faces", request.scan.native(),
                           scan_faces, base_faces << (2 * request.levels)),
               needed, request.ignore_size);
}

PLAIT_END_NAMESPACE
