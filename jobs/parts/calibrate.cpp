#include "parts/calibrate.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "io/unpublished.h"
#include "parts/part_work.h"
#include "store/left_overs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kTrialSeconds = 1;  ///< of the last trial, without reading the base mesh
constexpr double kMostTrialBytes = 1u << 30;
constexpr double kMostGrowth = 64;  ///< from one trial to the next
constexpr int kMostTrials = 4;      ///< after the first

double points_of(const PlannedPart& part, const PartCost& cost) {
  return static_cast<double>(part.faces) * cost.of_face() / cost.ns_per_point;
}

/// The starts of parts of which one has `edges` edges in the middle of the order.
std::vector<EdgeId> starts_around(EdgeId first, EdgeId edges, std::uint64_t all) {
  std::vector<EdgeId> starts = {0};
  if (first > 0) starts.push_back(first);
  if (first + edges < all) starts.push_back(first + edges);
  return starts;
}

}  // namespace

MachineRates rates_of(const Trial& least, const Trial& most) {
  const Trial over = most - least;
  MachineRates rates;
  rates.points_per_second =
      over.points / std::max({over.compute_seconds, most.compute_seconds / 10, 1e-9});
  rates.bytes_per_second =
      over.bytes / std::max({over.write_seconds, most.write_seconds / 10, 1e-9});
  rates.begin_seconds =
      std::max(most.begin_seconds + most.seconds() - most.points / rates.points_per_second -
                   most.bytes / rates.bytes_per_second,
               0.0);
  return rates;
}

MachineRates measure_machine(const Directory& plan_directory, const PlanFile& plan,
                             const EdgesInOrder& mesh, const PartCost& cost,
                             const std::filesystem::path& final_path,
                             const ProgressCallback& progress, const BackendRegistry& backends) {
  const EdgeId all = mesh.count();
  PartOptions options;
  options.progress = progress;
  const auto make = [&](EdgeId edges) {
    const EdgeId first = (all - edges) / 2;
    PlanFile trial = plan;
    trial.plan.parts = figures_of_parts(mesh, starts_around(first, edges, all), cost);
    const std::uint32_t part = first > 0 ? 1 : 0;
    UnpublishedDirectory directory(final_path, "partial", MadeProof::kMark, remove_made_files);
    const ComputedPart computed = PartWork::of(plan_directory, trial)
                                      ->compute(part, directory.directory(), options, backends);
    Trial made;
    for (const PartContent::FileOfPart& file : computed.content.files)
      made.bytes += static_cast<double>(file.bytes);
    made.points = points_of(trial.plan.parts[part], cost);
    made.begin_seconds = computed.begin_seconds;
    made.compute_seconds = computed.compute_seconds;
    made.write_seconds = computed.write_seconds;
    return made;
  };
  // A part of one edge has hardly any points, so its seconds are those that every part takes.
  const Trial least = make(1);
  Trial most = {};
  EdgeId edges = 1;
  for (int trials = 0; trials < kMostTrials && edges < all; ++trials) {
    // In steps, because the seconds of a tiny trial say little about a large one.
    const double seconds = most.points > 0 ? (most - least).seconds() : 0;
    const double growth =
        std::min({kTrialSeconds / std::max(seconds, 1e-3), kMostGrowth,
                  kMostTrialBytes / std::max(trials > 0 ? most.bytes : least.bytes, 1.0)});
    if (growth < 1.5) break;
    edges = static_cast<EdgeId>(
        std::min(static_cast<double>(edges) * growth, static_cast<double>(all)));
    most = make(edges);
    if ((most - least).seconds() > kTrialSeconds / 2) break;
  }
  return most.points > 0 ? rates_of(least, most) : rates_of({}, least);
}

double seconds_of(const PlannedPart& part, const PartCost& cost, const MachineRates& rates) {
  return rates.begin_seconds + points_of(part, cost) / rates.points_per_second +
         static_cast<double>(part.bytes) / rates.bytes_per_second;
}

PLAIT_END_NAMESPACE
