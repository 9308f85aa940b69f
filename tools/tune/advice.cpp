#include "tune/advice.h"

#include <fmt/format.h>

#include <algorithm>

#include "plait/backends/compression.h"

namespace plait::tune {
namespace {

/// The rows of a table, each choice once.
class Rows {
 public:
  ChoiceRow& of(const Choice& choice) {
    const auto found = std::ranges::find(rows_, choice, &ChoiceRow::choice);
    if (found != rows_.end()) return *found;
    rows_.push_back({choice});
    return rows_.back();
  }
  void name(const std::optional<Choice>& choice, std::string_view name) {
    if (!choice) return;
    std::string& names = of(*choice).names;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  std::vector<ChoiceRow> take() { return std::move(rows_); }

 private:
  std::vector<ChoiceRow> rows_;
};

void predict_row(const Findings& findings, const Choice& pick, ChoiceRow& row) {
  const auto seconds = [&](Bound bound) {
    return predict(work_of(findings.trials, row.choice, bound), findings.machine());
  };
  row.seconds = seconds(Bound::kValue);
  row.low = seconds(Bound::kLow);
  row.high = seconds(Bound::kHigh);
  double raw = 0;
  for (const SampledAttribute& attribute : findings.trials.attributes) raw += attribute.raw_bytes;
  for (const Work& work : work_of(findings.trials, row.choice))
    row.stored_bytes += work.stored_bytes;
  row.ratio = raw / row.stored_bytes;
  row.is_pick = row.choice == pick;
  row.is_like_pick =
      no_difference(findings.trials, findings.goal, row.choice, pick, findings.machine());
}

}  // namespace

Advice advise(const Findings& findings) {
  const Trials& trials = findings.trials;
  Advice advice;
  advice.pick = pick(trials, findings.goal, findings.machine());
  const std::uint64_t block_bytes = advice.pick.block_bytes;
  Rows rows;
  rows.name(advice.pick, "pick");
  for (const FrontMember& member :
       front_of(trials, findings.goal, block_bytes, findings.machine())) {
    ChoiceRow& row = rows.of(member.choice);
    row.on_front = true;
    row.next_from = member.next_from;
  }
  for (const CompressionPreset& preset : compression_presets())
    rows.name(preset_choice(trials, block_bytes, preset.name),
              fmt::format("preset {}", preset.name));
  if (findings.own_pipelines)
    rows.name(choice_with(trials, findings.own_block_bytes, *findings.own_pipelines), "as it is");
  advice.rows = rows.take();
  for (ChoiceRow& row : advice.rows) predict_row(findings, advice.pick, row);
  std::ranges::stable_sort(advice.rows, {}, &ChoiceRow::stored_bytes);
  advice.ranges = best_at_speeds(trials, findings.goal, block_bytes, findings.machine());
  advice.sentence = sentence(trials, findings.goal, advice.ranges);
  advice.command = command_for(trials, advice.pick, findings.command_start);
  return advice;
}

std::vector<std::string> compress_arguments(const Trials& trials, const Choice& choice) {
  std::vector<std::string> arguments;
  for (std::size_t id = 0; id < choice.trials.size(); ++id)
    arguments.push_back(fmt::format("{}={}", trials.attributes[id].schema.name,
                                    trials.trials[choice.trials[id]].pipeline));
  return arguments;
}

std::string command_for(const Trials& trials, const Choice& choice, const std::string& start) {
  const std::string block = size_argument(choice.block_bytes);
  const bool stores_raw = std::ranges::all_of(
      choice.trials, [&](std::size_t at) { return trials.trials[at].pipeline == "none"; });
  if (stores_raw) return fmt::format("{} --backend pread --block {}", start, block);
  std::string command = fmt::format("{} --backend compressed --block {}", start, block);
  for (const std::string& argument : compress_arguments(trials, choice))
    command += " --compress " + argument;
  return command;
}

}  // namespace plait::tune
