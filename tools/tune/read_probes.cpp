#include "tune/read_probes.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "instrument/statistics.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "tune/front.h"
#include "tune/scratch_directory.h"
#include "tune/store_copies.h"

namespace plait::tune {
namespace {

class Prober {
 public:
  Prober(const Store& store, const BackendRegistry& backends, const ProbeOptions& options,
         Findings& findings)
      : store_(store),
        backends_(backends),
        options_(options),
        findings_(findings),
        levels_(coarse_levels(store, options.most_bytes)) {}

  bool has_room() const {
    return free_disk_bytes(options_.directory) / 4 > levels_.bytes && options_.most_probes > 0;
  }

  /// Of the pipelines that were measured.
  void probe(const Choice& choice) {
    const ScratchDirectory scratch(options_.directory, "plait-tune");
    const std::filesystem::path path = scratch.path() / "probe.plait";
    copy_store(store_, findings_.trials, choice, levels_.finest_level, path, backends_,
               [&](std::uint64_t) { return options_.proceed(); });
    ReadProbe made{choice, levels_.finest_level, {}, {}, true};
    std::vector<std::vector<double>> seconds;
    for (int read = 0; read < options_.reads; ++read) {
      if (!options_.proceed()) throw Error(ErrorCode::kCancelled, "tune: cancelled");
      const CopyFigures figures = read_cold(path, store_.options().budget_bytes, backends_);
      made.is_cold = made.is_cold && figures.is_cold;
      seconds.resize(figures.read_seconds.size());
      for (std::size_t id = 0; id < seconds.size(); ++id)
        seconds[id].push_back(figures.read_seconds[id]);
      if (read == 0) made.works = works_of(choice, figures.stored_bytes);
    }
    for (const auto& of_attribute : seconds)
      made.seconds.push_back(instrument::median(of_attribute));
    findings_.probes.push_back(std::move(made));
    Machine machine = findings_.machine();
    findings_.reading = machine.reading = fit_reads(findings_.probes, machine);
    findings_.trials.corrections = corrections_of(findings_.trials, findings_.probes, machine);
  }

 private:
  /// What the copy took, with the times of the trials for its bytes of records.
  std::vector<Work> works_of(const Choice& choice, const std::vector<double>& stored) const {
    std::vector<Work> works = work_of(findings_.trials, choice);
    const std::vector<AttributeId> ids = refined_attributes(store_);
    for (std::size_t id = 0; id < works.size(); ++id) {
      const auto raw = static_cast<double>(level_bytes(store_, ids[id], levels_.finest_level));
      const double part = raw / findings_.trials.attributes[id].raw_bytes;
      works[id].encode_seconds *= part;
      works[id].decode_seconds *= part;
      works[id].stored_bytes = stored[id];
    }
    return works;
  }

  const Store& store_;
  const BackendRegistry& backends_;
  const ProbeOptions& options_;
  Findings& findings_;
  CoarseLevels levels_;
};

/// Blocks as they are, of the size for which the disk reads fastest.
std::optional<Choice> raw_choice(const Findings& findings) {
  std::optional<Choice> best;
  double least = 0;
  for (const std::uint64_t block_bytes : block_sizes(findings.trials)) {
    const auto none = preset_choice(findings.trials, block_bytes, "none");
    if (!none) continue;
    const double seconds = cost(Goal::kRead, work_of(findings.trials, *none), findings.machine());
    if (!best || seconds < least) best = none, least = seconds;
  }
  return best;
}

/// The best choice that was not probed, unless the best of all is better by more than the model may
/// be wrong.
std::optional<Choice> next_choice(const Findings& findings) {
  constexpr double kMostError = 1.3;
  const Choice best = pick(findings.trials, findings.goal, findings.machine());
  if (!was_probed(findings.trials, best)) return best;
  if (findings.goal != Goal::kRead && findings.goal != Goal::kBalanced) return std::nullopt;
  const auto seconds = [&](const Choice& choice) {
    return cost(findings.goal, work_of(findings.trials, choice), findings.machine());
  };
  std::optional<Choice> next;
  double least = kMostError * seconds(best);
  for (const Choice& choice : worthwhile_choices(findings.trials)) {
    if (was_probed(findings.trials, choice) || !(seconds(choice) < least)) continue;
    next = choice;
    least = seconds(choice);
  }
  return next;
}

}  // namespace

void probe_reads(const Store& store, const BackendRegistry& backends, const ProbeOptions& options,
                 Findings& findings) {
  Prober prober(store, backends, options, findings);
  if (!prober.has_room()) return;
  const auto probe = [&](const std::optional<Choice>& choice) {
    if (choice && !was_probed(findings.trials, *choice)) prober.probe(*choice);
  };
  try {
    probe(pick(findings.trials, findings.goal, findings.machine()));
    probe(raw_choice(findings));
    probe(pick(findings.trials, Goal::kRead, with_speed(findings.machine(), kFastestDisk)));
    while (static_cast<int>(findings.probes.size()) < options.most_probes) {
      const std::optional<Choice> next = next_choice(findings);
      if (!next || !options.proceed()) return;
      prober.probe(*next);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kCancelled) throw;
  }
}

}  // namespace plait::tune
