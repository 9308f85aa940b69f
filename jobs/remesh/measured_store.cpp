#include "remesh/measured_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "base/stopwatch.h"
#include "distance/crossings.h"
#include "distance/distances.h"
#include "remesh/sampled_surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void MeasuredStore::set_triangles(IndexedMesh mesh, std::uint64_t thousandths) {
  const Stopwatch clock;
  triangles_.emplace(std::move(mesh), [&] { progress_.begin("distances", thousandths); });
  report_.report_seconds += clock.seconds();
}

void MeasuredStore::measure(WorkPart to_store, WorkPart to_scan, double far) {
  const Stopwatch clock;
  const TriangleTree& store_tree = triangles_->tree;
  const TriangleSet scan{scan_.positions, scan_.faces},
      store{triangles_->mesh.positions, triangles_->mesh.faces};
  report_.to_store = measure_distances(scan, store_tree, store,
                                       {.samples = request_.report_samples,
                                        .far = far,
                                        .phase = "distance to the store",
                                        .progress = progress_.during(to_store)});
  report_.to_scan = measure_distances(store, scan_tree_, scan,
                                      {.samples = request_.report_samples,
                                       .far = far,
                                       .phase = "distance to the scan",
                                       .progress = progress_.during(to_scan)});
  report_.report_seconds += clock.seconds();
}

double MeasuredStore::farthest_vertex() {
  const Stopwatch clock;
  const double distance = plait::farthest_vertex(scan_, triangles_->tree);
  report_.report_seconds += clock.seconds();
  return distance;
}

void MeasuredStore::warn_of_far_places() const {
  const Distances& found = report_.to_store;
  if (!watch_.warn || found.far_share == 0) return;
  std::string text;
  for (const FarPlace& place : found.far_places)
    text += fmt::format("{} around ({:.6g}, {:.6g}, {:.6g}), up to {:.3g} % of the diagonal",
                        text.empty() ? "" : ",", place.at.x, place.at.y, place.at.z,
                        100 * place.distance / report_.diagonal);
  watch_.warn(fmt::format(
      "remesh {}: {:.2g} % of the scan is more than {} mean edges away from the store:{}: take "
      "more faces, as with --faces {}{}",
      request_.scan.native(), 100 * found.far_share, kFarEdges, text, 4 * report_.base.faces,
      request_.levels > 1
          ? fmt::format(" --levels {}, which makes as many vertices", request_.levels - 1)
          : std::string()));
}

void MeasuredStore::count_crossings(std::uint64_t thousandths) {
  const Stopwatch clock;
  const auto go_on = [&] { progress_.begin("crossings", thousandths); };
  const TriangleSet scan{scan_.positions, scan_.faces},
      store{triangles_->mesh.positions, triangles_->mesh.faces};
  report_.scan_crossings = find_crossings(scan, scan_tree_, go_on);
  report_.crossings = find_crossings(store, triangles_->tree, go_on);
  report_.report_seconds += clock.seconds();
  if (!watch_.warn) return;
  if (report_.scan_crossings.examined < scan.faces.size() ||
      report_.crossings.examined < store.faces.size())
    watch_.warn(fmt::format(
        "remesh {}: faces that pass through others were looked for among the first {} of {} faces "
        "of the scan and {} of {} small faces alone: nearly all of them reach across others",
        request_.scan.native(), report_.scan_crossings.examined, scan.faces.size(),
        report_.crossings.examined, store.faces.size()));
  if (report_.crossings.faces <= report_.scan_crossings.faces) return;
  const Point at = report_.crossings.first;
  watch_.warn(
      fmt::format("remesh {}: {} small faces pass through others, and {} faces of the scan do, "
                  "first around ({:.6g}, {:.6g}, {:.6g}): {}",
                  request_.scan.native(), report_.crossings.faces, report_.scan_crossings.faces,
                  at.x, at.y, at.z, crossings_remedy()));
}

std::string MeasuredStore::crossings_remedy() const {
  if (report_.lost_step > 0)
    return "faces of the scan are turned by its lost digits, and more faces do not help";
  if (sheets_coincide(report_.crossings.first))
    return "sheets of the scan lie on each other there, which more faces do not part: --weld makes "
           "them one";
  return fmt::format("take more faces where sheets are so near to each other, as with --faces {}",
                     4 * report_.base.faces);
}

/// Whether other vertices of the scan are where those of the face nearest to `p` are.
bool MeasuredStore::sheets_coincide(const Point& p) const {
  const std::array<VertexId, 3>& face = scan_.faces[scan_tree_.closest(p).face];
  return std::ranges::count_if(face, [&](VertexId corner) {
           return std::ranges::count(scan_.positions, scan_.positions[corner]) > 1;
         }) > 1;
}

PLAIT_END_NAMESPACE
