#include "tune/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plait/byte_text.h"

namespace plait::tune {
namespace {

using Json = nlohmann::ordered_json;

/// Bytes a second in GB/s, with the interval.
std::string rate_text(const Figure& rate) {
  if (!std::isfinite(rate.high)) return fmt::format("{:.3g}", rate.value / 1e9);
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", rate.value / 1e9, rate.low / 1e9,
                     rate.high / 1e9);
}

/// Seconds a byte as bytes a second, and stored bytes a byte as a ratio.
Figure inverse(const Figure& figure) {
  const auto over = [](double value) {
    return value > 0 ? 1 / value : std::numeric_limits<double>::infinity();
  };
  return {over(figure.value), over(figure.high), over(figure.low)};
}

std::string seconds_text(double seconds) {
  return seconds >= 0.1 ? fmt::format("{:.3g} s", seconds)
                        : fmt::format("{:.3g} ms", 1e3 * seconds);
}
std::string seconds_text(const std::optional<double>& seconds) {
  return seconds ? seconds_text(*seconds) : "-";
}

std::string threshold_text(double bytes_per_second) {
  return fmt::format("{:.3g} MB/s", bytes_per_second / 1e6);
}

/// The trials of an attribute with blocks of this size, the smallest first.
std::vector<const Trial*> trials_of(const Trials& trials, std::size_t attribute,
                                    std::uint64_t block_bytes) {
  std::vector<std::pair<double, const Trial*>> found;
  for (const Trial& trial : trials.trials)
    if (trial.attribute == attribute && trial.block_bytes == block_bytes && is_measured(trial))
      found.emplace_back(rates_of(trials, trial).stored.value, &trial);
  std::ranges::stable_sort(found, {}, &std::pair<double, const Trial*>::first);
  std::vector<const Trial*> sorted;
  sorted.reserve(found.size());
  for (const auto& [stored, trial] : found) sorted.push_back(trial);
  return sorted;
}

bool is_chosen_on_front(const Findings& findings, const Advice& advice, const Trial& trial) {
  return std::ranges::any_of(advice.rows, [&](const ChoiceRow& row) {
    return row.on_front && &findings.trials.trials[row.choice.trials[trial.attribute]] == &trial;
  });
}

std::string floors_text(const MeasuredDisk& disk) {
  std::string text;
  for (const BlockFloor& floor : disk.floors)
    text += fmt::format("  in blocks of {:<7} reads {} GB/s, writes {} GB/s durably\n",
                        size_argument(floor.block_bytes), rate_text(floor.read),
                        rate_text(floor.write));
  if (disk.disk.burst_bytes > 0)
    text += fmt::format("  after a pause, {:.0f} MB at {:.2f} GB/s before these rates\n",
                        disk.disk.burst_bytes / 1e6, disk.disk.burst_read / 1e9);
  return text;
}

std::string reading_text(const Findings& findings) {
  if (findings.probes.empty()) return "; no choice was read from the disk";
  return fmt::format(
      "\n{} choices were stored there and read, to level {}: a read takes {:.2f} of the longer of "
      "disk and processors, and {:.2f} of the shorter",
      findings.probes.size(), findings.probes.front().finest_level, findings.reading.factor,
      findings.reading.factor * findings.reading.added);
}

std::string head_text(const Findings& findings) {
  double raw = 0;
  std::size_t parts = 0;
  for (const SampledAttribute& attribute : findings.trials.attributes) {
    raw += attribute.raw_bytes;
    parts += attribute.parts;
  }
  const MeasuredDisk& disk = findings.disk;
  return fmt::format(
      "{}: {} of records to level {}; {} pipelines and block sizes tried on {} ({} blocks, seed "
      "{}), {} rounds, {:.1f} s{}\n{}"
      "{}: {} {}, {} to the first byte, {} runs\n{}"
      "{} threads get {:.2f} processors of this machine at the moment{}\n",
      findings.input, format_bytes(static_cast<std::uint64_t>(raw)), findings.finest_level,
      findings.trials.trials.size(), format_bytes(findings.sample_bytes), parts, findings.seed,
      findings.rounds, findings.seconds, findings.is_interrupted ? ", interrupted" : "",
      findings.note.empty() ? "" : findings.note + "\n", disk.disk.name, format_bytes(disk.bytes),
      disk.is_cold ? "cold" : "from memory", seconds_text(disk.disk.latency), disk.runs,
      floors_text(disk), findings.threads, findings.processors, reading_text(findings));
}

std::string pipelines_text(const Findings& findings, const Advice& advice) {
  const Trials& trials = findings.trials;
  std::string text;
  for (std::size_t id = 0; id < trials.attributes.size(); ++id) {
    text += fmt::format("\n{}, blocks of {} (* on the front for {})\n  {:<34} {:<22} {:<24} {}\n",
                        trials.attributes[id].schema.name, size_argument(advice.pick.block_bytes),
                        to_string(findings.goal), "pipeline", "ratio", "encodes, GB/s a core",
                        "decodes, GB/s a core");
    for (const Trial* trial : trials_of(trials, id, advice.pick.block_bytes)) {
      const Rates rates = rates_of(trials, *trial);
      const Figure ratio = inverse(rates.stored);
      text += fmt::format(
          "{} {:<34} {:<22} {:<24} {}\n", is_chosen_on_front(findings, advice, *trial) ? "*" : " ",
          trial->pipeline,
          std::isfinite(ratio.high)
              ? fmt::format("{:.2f} ({:.2f} to {:.2f})", ratio.value, ratio.low, ratio.high)
              : fmt::format("{:.2f}", ratio.value),
          rate_text(inverse(rates.encode)), rate_text(inverse(rates.decode)));
    }
  }
  return text;
}

std::string choices_text(const Findings& findings, const Advice& advice) {
  std::string text = fmt::format(
      "\nPredicted for the whole store on {}\n  {:>10} {:>7} {:>10} {:>10} {:>10} {:>10}  choice\n",
      findings.disk.disk.name, "stored", "ratio", "read", "write", "update", "cold patch");
  for (const ChoiceRow& row : advice.rows)
    text += fmt::format(
        "{} {:>10} {:>7.2f} {:>10} {:>10} {:>10} {:>10}  {}{}{}{}\n", row.on_front ? "*" : " ",
        format_bytes(static_cast<std::uint64_t>(row.stored_bytes)), row.ratio,
        seconds_text(row.seconds.read), seconds_text(row.seconds.write),
        seconds_text(row.seconds.update), seconds_text(row.seconds.patch),
        to_text(findings.trials, row.choice),
        row.names.empty() ? "" : fmt::format(" [{}]", row.names),
        row.is_like_pick && !row.is_pick ? "; no difference from the pick" : "",
        row.next_from
            ? fmt::format("; the next * takes less time from {} on", threshold_text(*row.next_from))
            : "");
  return text;
}

std::string other_disks_text(const Findings& findings, const Advice& advice) {
  std::string text = fmt::format("\nOn other disks\n  {:<20} {:>10} {:>10} {:>10} {:>10}  choice\n",
                                 "", "read", "write", "update", "cold patch");
  for (const Disk& disk : classes_of_disks()) {
    const Machine machine{disk, findings.processors, findings.reading};
    for (const Choice& choice : {advice.pick, pick(findings.trials, findings.goal, machine)}) {
      const bool is_best = choice != advice.pick;
      const Predicted seconds = predict(work_of(findings.trials, choice), machine);
      text += fmt::format("  {:<20} {:>10} {:>10} {:>10} {:>10}  {}\n", is_best ? "" : disk.name,
                          seconds_text(seconds.read), seconds_text(seconds.write),
                          seconds_text(seconds.update), seconds_text(seconds.patch),
                          is_best ? "best: " + to_text(findings.trials, choice) : "the pick");
      if (pick(findings.trials, findings.goal, machine) == advice.pick) break;
    }
  }
  return text;
}

Json figure_json(const Figure& figure) {
  // JSON has no infinity: an unknown end is null.
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  return {
      {"value", number(figure.value)}, {"low", number(figure.low)}, {"high", number(figure.high)}};
}

Json seconds_json(const Predicted& seconds) {
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  return {{"read", number(seconds.read)},
          {"write", number(seconds.write)},
          {"update", seconds.update ? number(*seconds.update) : Json()},
          {"cold_patch", number(seconds.patch)}};
}

Json disk_json(const Disk& disk) {
  return {{"name", disk.name},
          {"read_bytes_a_second", disk.read},
          {"write_bytes_a_second", disk.write},
          {"burst_bytes", disk.burst_bytes},
          {"burst_read_bytes_a_second", disk.burst_read},
          {"latency_seconds", disk.latency},
          {"random_read_bytes_a_second", disk.random_read},
          {"unwritten_bytes", disk.unwritten_bytes},
          {"measured", disk.is_measured}};
}

Json floors_json(const MeasuredDisk& disk) {
  Json floors = Json::array();
  for (const BlockFloor& floor : disk.floors)
    floors.push_back({{"block_bytes", floor.block_bytes},
                      {"read", figure_json(floor.read)},
                      {"write", figure_json(floor.write)}});
  return floors;
}

Json choice_json(const Trials& trials, const Choice& choice) {
  Json pipelines = Json::object();
  for (std::size_t id = 0; id < choice.trials.size(); ++id)
    pipelines[trials.attributes[id].schema.name] = trials.trials[choice.trials[id]].pipeline;
  return {{"block_bytes", choice.block_bytes}, {"pipelines", pipelines}};
}

Json reading_json(const Findings& findings) {
  Json probes = Json::array();
  for (const ReadProbe& probe : findings.probes) {
    Json json = choice_json(findings.trials, probe.choice);
    json["finest_level"] = probe.finest_level;
    json["cold"] = probe.is_cold;
    json["seconds"] = probe.seconds;
    probes.push_back(std::move(json));
  }
  return {{"added", findings.reading.added},
          {"factor", findings.reading.factor},
          {"probes", std::move(probes)}};
}

Json trials_json(const Trials& trials) {
  Json all = Json::array();
  for (const Trial& trial : trials.trials) {
    if (!is_measured(trial)) continue;
    const Rates rates = rates_of(trials, trial);
    all.push_back({{"attribute", trials.attributes[trial.attribute].schema.name},
                   {"block_bytes", trial.block_bytes},
                   {"pipeline", trial.pipeline},
                   {"needs_other_blocks", trial.needs_other_blocks},
                   {"ratio", figure_json(inverse(rates.stored))},
                   {"encode_bytes_a_second", figure_json(inverse(rates.encode))},
                   {"decode_bytes_a_second", figure_json(inverse(rates.decode))}});
  }
  return all;
}

Json rows_json(const Findings& findings, const Advice& advice) {
  Json rows = Json::array();
  for (const ChoiceRow& row : advice.rows) {
    Json json = choice_json(findings.trials, row.choice);
    json["names"] = row.names;
    json["front"] = row.on_front;
    json["pick"] = row.is_pick;
    json["no_difference_from_pick"] = row.is_like_pick;
    json["next_is_faster_from_bytes_a_second"] = row.next_from ? Json(*row.next_from) : Json();
    json["stored_bytes"] = row.stored_bytes;
    json["ratio"] = row.ratio;
    json["seconds"] = seconds_json(row.seconds);
    json["seconds_low"] = seconds_json(row.low);
    json["seconds_high"] = seconds_json(row.high);
    rows.push_back(std::move(json));
  }
  return rows;
}

}  // namespace

std::string to_text(const Findings& findings, const Advice& advice) {
  return head_text(findings) + pipelines_text(findings, advice) + choices_text(findings, advice) +
         other_disks_text(findings, advice) + "\n" + advice.sentence + "\n" + advice.command + "\n";
}

nlohmann::ordered_json to_json(const Findings& findings, const Advice& advice) {
  const Trials& trials = findings.trials;
  Json report = {{"input", findings.input},
                 {"note", findings.note},
                 {"goal", to_string(findings.goal)},
                 {"seed", findings.seed},
                 {"sample_bytes", findings.sample_bytes},
                 {"rounds", findings.rounds},
                 {"seconds", findings.seconds},
                 {"interrupted", findings.is_interrupted},
                 {"threads", findings.threads},
                 {"processors", findings.processors},
                 {"finest_level", findings.finest_level}};
  Json attributes = Json::array();
  for (const SampledAttribute& attribute : trials.attributes)
    attributes.push_back({{"name", attribute.schema.name},
                          {"raw_bytes", attribute.raw_bytes},
                          {"sampled_blocks", attribute.parts},
                          {"sample_is_all", attribute.is_whole}});
  report["attributes"] = attributes;
  report["disk"] = disk_json(findings.disk.disk);
  report["disk"]["floors"] = floors_json(findings.disk);
  report["disk"]["bytes"] = findings.disk.bytes;
  report["disk"]["runs"] = findings.disk.runs;
  report["disk"]["cold"] = findings.disk.is_cold;
  report["reading"] = reading_json(findings);
  report["trials"] = trials_json(trials);
  report["choices"] = rows_json(findings, advice);
  Json others = Json::array();
  for (const Disk& disk : classes_of_disks()) {
    const Machine machine{disk, findings.processors, findings.reading};
    const Choice best = pick(trials, findings.goal, machine);
    Json json = disk_json(disk);
    json["pick_seconds"] = seconds_json(predict(work_of(trials, advice.pick), machine));
    json["best"] = choice_json(trials, best);
    json["best_seconds"] = seconds_json(predict(work_of(trials, best), machine));
    others.push_back(std::move(json));
  }
  report["other_disks"] = others;
  Json ranges = Json::array();
  for (const SpeedRange& range : advice.ranges) {
    Json json = choice_json(trials, range.choice);
    json["slowest_bytes_a_second"] = range.slowest;
    json["fastest_bytes_a_second"] = std::isfinite(range.fastest) ? Json(range.fastest) : Json();
    ranges.push_back(std::move(json));
  }
  report["best_at_speeds"] = ranges;
  report["pick"] = choice_json(trials, advice.pick);
  report["advice"] = advice.sentence;
  report["command"] = advice.command;
  return report;
}

}  // namespace plait::tune
