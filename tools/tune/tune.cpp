#include "tune/tune.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "plait/backends/registry.h"
#include "plait/block_maker.h"
#include "plait/error.h"
#include "plait/stopwatch.h"
#include "tune/block_trial.h"
#include "tune/candidates.h"
#include "tune/read_probes.h"
#include "tune/round_robin.h"

namespace plait::tune {
namespace {

using Grids = std::vector<std::unique_ptr<BlockGrid>>;

/// The sizes of blocks that divide the levels differently, ascending. Of two that do not, the
/// larger one stays, or the store's own.
Grids grids_of(const Store& store) {
  const std::uint64_t own = store.options().block_bytes;
  Grids grids;
  for (const std::uint64_t size : candidate_block_sizes(own)) {
    auto grid = std::make_unique<BlockGrid>(store, size);
    if (!grids.empty() && grids.back()->same_blocks(*grid)) {
      if (grids.back()->block_bytes() == own) continue;
      grids.pop_back();
    }
    grids.push_back(std::move(grid));
  }
  return grids;
}

/// The sizes of blocks that the disk is measured with. Larger ones are no faster.
std::vector<std::uint64_t> floor_sizes(std::uint64_t own_block_bytes) {
  constexpr std::uint64_t kLargest = 8u << 20;
  std::vector<std::uint64_t> sizes = candidate_block_sizes(own_block_bytes);
  std::erase_if(sizes, [](std::uint64_t size) { return size > kLargest; });
  return sizes;
}

/// How many processors the threads get, with work as that of a store.
double measured_processors(const Store& store, const PipelineRegistry& registry,
                           const BlockGrid& grid, const Sample& sample, int threads) {
  const auto parts =
      std::ranges::find_if(sample.parts, [](const auto& each) { return !each.empty(); });
  return processors_for(threads, [&] {
    StoreBytes bytes(store, 0);
    BlockTrials blocks(registry, bytes);
    Outcome outcome;
    for (int visit = 0; visit < 3; ++visit) blocks.measure(grid, parts->front(), "zstd:1", outcome);
  });
}

/// The disk is measured with as many bytes as the store has, within limits: the start and the end
/// of a run weigh as much then.
std::uint64_t disk_bytes(const Store& store, const BlockGrid& grid, std::uint64_t most) {
  constexpr std::uint64_t kFewest = 16u << 20;
  std::uint64_t bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level)
      bytes += grid.geometry(id, level).total_bytes();
  return std::clamp(bytes, kFewest, std::max(kFewest, most));
}

std::uint64_t bytes_in(const Sample& sample) {
  std::uint64_t bytes = 0;
  for (const auto& parts : sample.parts)
    for (const SamplePart& part : parts) bytes += part.bytes;
  return bytes;
}

/// Of a compressed store.
std::optional<std::vector<std::string>> own_pipelines(const Store& store) {
  if (!store.backend_traits().compressed) return std::nullopt;
  std::vector<std::string> pipelines;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (const int finest = store.attributes()[id].finest_level; finest > store.base_level())
      pipelines.push_back(with_recipe(store.level_file(id, finest).pipeline, {}));
  return pipelines;
}

}  // namespace

Findings measure_store(const Store& store, const PipelineRegistry& registry,
                       const TuneOptions& options) {
  if (store.finest_level() == store.base_level())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("tune {}: expected a store with at least one level, found none",
                            store.path().native()));
  const Stopwatch clock;
  Findings findings;
  findings.goal = options.goal;
  findings.seed = options.seed;
  findings.threads = options.threads;
  findings.finest_level = store.finest_level();
  findings.own_block_bytes = store.options().block_bytes;
  findings.own_pipelines = own_pipelines(store);
  const auto proceed = [&](std::string_view phase, double done) {
    findings.is_interrupted =
        findings.is_interrupted || !options.proceed(phase, std::min(done, 1.0));
    return !findings.is_interrupted;
  };
  const Grids grids = grids_of(store);
  // The rest is for the pipelines; probes go on if that ends early.
  const double disk_seconds = 0.2 * options.seconds;
  const double trial_seconds = options.probes > 0 ? 0.65 * options.seconds : options.seconds;
  findings.disk =
      measure_disk(options.directory, disk_bytes(store, *grids.front(), options.disk_bytes),
                   floor_sizes(findings.own_block_bytes), options.threads, disk_seconds,
                   [&] { return proceed("disk", clock.seconds() / options.seconds); });
  StoreBytes bytes(store, options.memory_bytes);
  const Sample sample = take_sample(bytes, *grids.back(), options.blocks, options.seed, [&] {
    return proceed("sample", clock.seconds() / options.seconds);
  });
  findings.sample_bytes = bytes_in(sample);
  if (!findings.is_interrupted)
    findings.processors =
        measured_processors(store, registry, *grids.front(), sample, options.threads);
  findings.trials = plan_trials(store, registry, grids, sample);
  findings.rounds = measure_in_turn(store, registry, bytes, grids, sample, options.visits,
                                    findings.trials, [&](const TrialProgress& now) {
                                      if (!proceed("pipelines", clock.seconds() / options.seconds))
                                        return false;
                                      return now.rounds == 0 || clock.seconds() < trial_seconds;
                                    });
  if (options.probes > 0 && !findings.is_interrupted) {
    ProbeOptions probes;
    probes.directory = options.directory;
    probes.most_probes = options.probes;
    probes.proceed = [&] {
      if (!proceed("reads", clock.seconds() / options.seconds)) return false;
      return findings.probes.empty() || clock.seconds() < options.seconds;
    };
    probe_reads(store, default_backends(registry), probes, findings);
  }
  findings.seconds = clock.seconds();
  if (findings.is_interrupted)
    for (std::size_t id = 0; id < findings.trials.attributes.size(); ++id)
      if (std::ranges::none_of(findings.trials.trials, [&](const Trial& trial) {
            return trial.attribute == id && is_measured(trial);
          }))
        throw Error(ErrorCode::kCancelled, "tune: cancelled before there was anything to report");
  return findings;
}

}  // namespace plait::tune
