#include "parts/calibrate.h"

#include <algorithm>
#include <vector>

#include "io/partial_output.h"
#include "parts/compute_part.h"
#include "store/left_overs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kTrialSeconds = 1;  ///< of the last trial, without reading the base mesh
constexpr std::uint64_t kMostTrialBytes = 1u << 30;
constexpr double kMostGrowth = 64;  ///< from one trial to the next
constexpr int kMostTrials = 4;

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

MachineRates measure_machine(const Directory& plan_directory, const PlanFile& plan,
                             const Topology& mesh, const PartCost& cost,
                             const std::filesystem::path& final_path,
                             const ProgressCallback& progress, const BackendRegistry& backends) {
  const auto all = static_cast<EdgeId>(mesh.edges.size());
  PartOptions options;
  options.progress = progress;
  MachineRates rates;
  EdgeId edges = 1;
  for (int trials = 0; trials < kMostTrials; ++trials) {
    const EdgeId first = (all - edges) / 2;
    PlanFile trial = plan;
    trial.plan.parts = figures_of_parts(mesh, starts_around(first, edges, all), cost);
    const std::uint32_t part = first > 0 ? 1 : 0;
    const PlannedPart& figures = trial.plan.parts[part];
    PartialDirectory directory(final_path, "partial", MadeProof::kMark, remove_made_files);
    const ComputedPart computed =
        compute_part(plan_directory, trial, part, directory.directory(), options, backends);
    std::uint64_t bytes = 0;
    for (const PartContent::LevelOfPart& level : computed.content.levels) bytes += level.bytes;
    rates.begin_seconds = computed.begin_seconds;
    rates.points_per_second = points_of(figures, cost) / std::max(computed.compute_seconds, 1e-9);
    rates.bytes_per_second = static_cast<double>(bytes) / std::max(computed.write_seconds, 1e-9);
    // In steps, because the seconds of a tiny trial say little about a large one.
    const double seconds = computed.compute_seconds + computed.write_seconds;
    if (seconds > kTrialSeconds / 2 || edges == all) break;
    const double growth = std::min({kTrialSeconds / seconds, kMostGrowth,
                                    static_cast<double>(kMostTrialBytes) /
                                        static_cast<double>(std::max<std::uint64_t>(bytes, 1))});
    if (growth < 1.5) break;
    edges = static_cast<EdgeId>(
        std::min(static_cast<double>(edges) * growth, static_cast<double>(all)));
  }
  return rates;
}

double seconds_of(const PlannedPart& part, const PartCost& cost, const MachineRates& rates) {
  return rates.begin_seconds + points_of(part, cost) / rates.points_per_second +
         static_cast<double>(part.bytes) / rates.bytes_per_second;
}

PLAIT_END_NAMESPACE
