#include "remesh/choose_depths.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "prune/distance_depths.h"
#include "remesh/tolerance_search.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kBalance = 1;  ///< levels by which neighbours differ, at most
/// Of the largest distance, for what lies between the points that are measured.
constexpr double kKeptBackFromScan = 1.0 / 32;
/// Of a trial.
constexpr WorkPart kTrialDepths = {0, 400}, kDepthsStore = {400, 700}, kDepthsScan = {700, 1000};

}  // namespace

BaseMesh choose_depths(Store& all_levels, const SampledSurface& surface, WorkPart part,
                       const ScanProgress& progress, const MeasureDrawn& measure,
                       RemeshReport& report) {
  const double from_scan = std::max(report.to_store.max, report.to_scan.max);
  const double limit = std::max((1 - kKeptBackFromScan) * report.max_distance, from_scan);
  ToleranceSearch search(limit, from_scan);
  BaseMesh base;
  for (WorkPart left = part;; left = left.nth(1, 2)) {
    const WorkPart now = left.nth(0, 2);
    const Stopwatch clock;
    // Faces are measured in rounds, and only the first has all of them.
    const ProgressCallback of_depths = progress.during(now.of(kTrialDepths));
    const JobWatch watch{
        .progress = [&of_depths, most = std::uint64_t{0}](const Progress& round) mutable {
          most = std::max(most, round.done);
          return !of_depths || of_depths({round.phase, most, std::max(most, round.total)});
        }};
    std::vector<std::uint8_t> depths(surface.base.face_count(),
                                     static_cast<std::uint8_t>(surface.levels));
    if (search.tolerance() > 0)
      depths =
          depths_by_distance(all_levels, {.number = search.tolerance()}, kBalance, watch).depths;
    report.faces_of_level.assign(static_cast<std::size_t>(surface.levels) + 1, 0);
    for (const std::uint8_t depth : depths) ++report.faces_of_level[depth];
    base = surface.base.with_depths(std::move(depths));
    ++report.depth_trials;
    report.tolerance = search.tolerance();
    report.prune_seconds += clock.seconds();
    const double found =
        measure(drawn_triangles(surface, base), now.of(kDepthsStore), now.of(kDepthsScan));
    // All levels were near enough.
    if (found <= limit || search.tolerance() == 0) break;
    search.next(found);
  }
  const LevelCounts counts = counts_at_level(base, surface.levels);
  report.vertices = counts.vertices;
  report.small_faces = counts.faces;
  return base;
}

PLAIT_END_NAMESPACE
