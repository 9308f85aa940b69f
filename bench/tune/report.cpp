#include "tune/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/text.h"
#include "instrument/figure_text.h"
#include "instrument/page.h"

namespace plait::tune {
namespace {

using instrument::Estimate;
using instrument::seconds_text;
using Json = nlohmann::ordered_json;

constexpr NameTable<Goal, 5> kWords("goal",
                                    {{Goal::kRead, "For a full read"},
                                     {Goal::kWrite, "For a full write"},
                                     {Goal::kUpdate,
                                      "For reading, changing and writing all records"},
                                     {Goal::kSize, "For size"},
                                     {Goal::kBalanced, "For reading, writing and size together"}});

std::string bytes_text(double bytes) { return format_bytes(static_cast<std::uint64_t>(bytes)); }

double ratio_of(const TuneFindings& findings, const Measured& one) {
  return static_cast<double>(findings.raw_bytes) / one.stored_bytes();
}

/// "the pick", "equal within 3 %", "1.2 to 1.4 times the cost", or why there is no figure.
std::string remark_on(const TuneFindings& findings, const Decision& decision, std::size_t at) {
  const Measured& one = findings.choices[at];
  if (!one.refused.empty()) return "refused: " + one.refused;
  if (at == decision.pick) return "the pick";
  if (one.runs.empty()) return "not measured: the time was up";
  std::string text;
  if (findings.goal == Goal::kUpdate && !one.runs.back().can_change) return "cannot be changed";
  const Beside& beside = *decision.beside[at];
  const Estimate& factor = beside.cost.factor;
  if (findings.goal == Goal::kSize)
    text = beside.is_tied ? fmt::format("equal within {:.0f} %", 100 * (kEqualBytes - 1))
                          : fmt::format("{:.2f} times the pick", factor.value);
  else if (beside.is_tied && factor.low < kEqualWithin && factor.high < kEqualWithin)
    text = fmt::format("equal within {:.0f} %", 100 * (kEqualWithin - 1));
  else if (factor.confidence == 0)
    text = fmt::format("{:.2f} times the pick in one round, which shows nothing", factor.value);
  else if (beside.is_tied)
    text = fmt::format("no difference shown ({:.2f} to {:.2f} times)", factor.low, factor.high);
  else
    text = fmt::format("{:.2f} to {:.2f} times the pick{}", factor.low, factor.high,
                       factor.low < 1 && factor.high > 1 ? ": more rounds would tell" : "");
  return text + (one.left ? fmt::format("; left after {} rounds", one.runs.size()) : "");
}

std::string interval_text(const Estimate& seconds) {
  return seconds.count < 2 ? seconds_text(seconds.value)
                           : fmt::format("{} ({} to {})", seconds_text(seconds.value),
                                         seconds_text(seconds.low), seconds_text(seconds.high));
}

struct DiskClass {
  const char* name;
  double speed;
};
constexpr std::array<DiskClass, 3> kDisks = {
    {{"100 MB/s (hard disk)", 1e8}, {"500 MB/s (SATA)", 5e8}, {"3 GB/s (NVMe)", 3e9}}};

const Measured& best_at(const TuneFindings& findings, double speed) {
  return *std::ranges::min_element(findings.choices, {}, [&](const Measured& one) {
    return one.runs.empty() ? std::numeric_limits<double>::infinity() : read_seconds_at(one, speed);
  });
}

instrument::Table table_of(const TuneFindings& findings, const Decision& decision) {
  instrument::Table table =
      instrument::table_with("#stored|#ratio|#read|#write|beside the pick|choice",
                             {"Stored in full, read and written", "The pick is green."});
  for (std::size_t at = 0; at < findings.choices.size(); ++at) {
    const Measured& one = findings.choices[at];
    const bool is_pick = at == decision.pick;
    instrument::Table::Row& row = table.rows.emplace_back();
    row.tone = is_pick ? instrument::Tone::kGood : instrument::Tone::kPlain;
    if (one.runs.empty()) {
      row.cells.assign(4, "-");
    } else {
      const Estimate read = estimate(one, &CopyRun::read_seconds);
      const Estimate write = estimate(one, &CopyRun::write_seconds);
      row.cells = {bytes_text(one.stored_bytes()), fmt::format("{:.2f}", ratio_of(findings, one)),
                   interval_text(read), interval_text(write)};
    }
    row.cells.emplace_back(remark_on(findings, decision, at));
    row.cells.emplace_back((is_pick ? "* " : "  ") + one.choice.name);
  }
  return table;
}

/// What a reader must know before believing the figures.
std::vector<std::string> doubts_of(const TuneFindings& findings) {
  std::vector<std::string> lines = findings.notes;
  if (findings.is_interrupted)
    lines.push_back("interrupted: the figures are of what there was by then");
  if (findings.seconds_for_enough > 0)
    lines.push_back(fmt::format(
        "the time was up before {} rounds, so the pick may differ from call to call; --seconds "
        "{:.0f} would be enough",
        kEnoughRounds, std::ceil(findings.seconds_for_enough)));
  if (const double others = findings.surroundings.disturbance(); others > instrument::kDisturbed)
    lines.push_back(fmt::format(
        "the processors were busy: other programs and machines took {:.0f} % of their time, so "
        "choices that compute more look slower than they are; measure again on a machine at rest",
        100 * others));
  const bool warm = std::ranges::any_of(findings.choices, [](const Measured& one) {
    return !one.runs.empty() && !one.runs.back().is_cold;
  });
  if (warm) lines.push_back("the files were in memory while they were read");
  if (!findings.sample.is_complete)
    lines.push_back(
        "the time was up before all pipelines were tried on the sample; more --seconds "
        "try all");
  for (const auto& [why, pipelines] : findings.sample.refused)
    lines.push_back(fmt::format("the sample refused {}: {}", fmt::join(pipelines, " and "), why));
  return lines;
}

std::string method_text(const TuneFindings& findings) {
  std::size_t tried = 0, kept = 0;
  for (const auto& pipelines : findings.sample.pipelines) {
    tried += pipelines.size();
    kept += not_dominated(pipelines).size();
  }
  std::size_t rounds = 0, measured = 0;
  for (const Measured& one : findings.choices) {
    rounds = std::max(rounds, one.runs.size());
    measured += !one.runs.empty();
  }
  return fmt::format(
      "{}: {} of records to level {}, blocks of {}. {} pipelines of attributes were tried on {}, "
      "and {} of them are not dominated. {} of {} choices were stored in full under {} and read, "
      "{} round{}, {:.0f} s. Intervals are of 95 %. Writing contains reading the source.",
      findings.input, format_bytes(findings.raw_bytes), findings.finest_level,
      format_bytes(findings.block_bytes), tried, format_bytes(findings.sample.bytes), kept,
      measured, findings.choices.size(), findings.directory.native(), rounds,
      rounds == 1 ? "" : "s", findings.seconds);
}

instrument::Table disks_table(const TuneFindings& findings, const Measured& pick) {
  instrument::Table table = instrument::table_with("disk|#the pick|#the best|which");
  for (const DiskClass& disk : kDisks) {
    const Measured& best = best_at(findings, disk.speed);
    table.rows.push_back({{disk.name, seconds_text(read_seconds_at(pick, disk.speed)),
                           seconds_text(read_seconds_at(best, disk.speed)), best.choice.name}});
  }
  return table;
}

/// The advice in a sentence.
std::string advice_text(const TuneFindings& findings, const Decision& decision) {
  const Measured& pick = findings.choices[decision.pick];
  std::vector<std::string> equal;
  for (std::size_t at = 0; at < decision.beside.size(); ++at)
    if (decision.beside[at] && decision.beside[at]->is_tied)
      equal.push_back(findings.choices[at].choice.name);
  return fmt::format(
      "{}: {}. It takes {} ({:.2f} to 1), is read in {} and written in {}.{}",
      kWords.name_of(findings.goal), pick.choice.name, bytes_text(pick.stored_bytes()),
      ratio_of(findings, pick), seconds_text(estimate(pick, &CopyRun::read_seconds).value),
      seconds_text(estimate(pick, &CopyRun::write_seconds).value),
      equal.empty() ? "" : fmt::format(" Not shown to differ: {}.", fmt::join(equal, "; ")));
}

/// The command that follows it.
std::string advised_command(const TuneFindings& findings, const Decision& decision) {
  return fmt::format("{} {}", findings.command_start,
                     findings.choices[decision.pick].choice.options());
}

}  // namespace

double read_seconds_at(const Measured& measured, double bytes_per_second) {
  return std::max(measured.stored_bytes() / bytes_per_second,
                  estimate(measured, &CopyRun::warm_seconds).value);
}

std::string to_text(const TuneFindings& findings, const Decision& decision) {
  instrument::Page page;
  page.add(instrument::Paragraph{method_text(findings)});
  page.add(instrument::List{doubts_of(findings), instrument::Tone::kDoubt});
  page.add(table_of(findings, decision));
  page.add(instrument::Paragraph{
      "Full reads of other disks, by the formula max(stored / speed, seconds from memory):"});
  page.add(disks_table(findings, findings.choices[decision.pick]));
  page.add(instrument::Paragraph{advice_text(findings, decision)});
  return to_text(page) + advised_command(findings, decision) + "\n";
}

Json to_json(const TuneFindings& findings, const Decision& decision) {
  const Measured& pick = findings.choices[decision.pick];
  Json choices = Json::array(), disks = Json::array();
  for (std::size_t at = 0; at < findings.choices.size(); ++at) {
    const Measured& one = findings.choices[at];
    Json json = {{"name", one.choice.name},
                 {"options", one.choice.options()},
                 {"pick", at == decision.pick},
                 {"rounds", one.runs.size()},
                 {"left", one.left},
                 {"refused", one.refused.empty() ? Json() : Json(one.refused)}};
    if (!one.runs.empty()) {
      json["stored_bytes"] = one.stored_bytes();
      json["ratio"] = ratio_of(findings, one);
      json["can_change_in_place"] = one.runs.back().can_change;
      json["read_seconds"] = instrument::to_json(estimate(one, &CopyRun::read_seconds));
      json["write_seconds"] = instrument::to_json(estimate(one, &CopyRun::write_seconds));
      json["seconds_from_memory"] = instrument::to_json(estimate(one, &CopyRun::warm_seconds));
    }
    if (decision.beside[at]) {
      json["cost_over_the_picks"] = instrument::to_json(decision.beside[at]->cost.factor);
      json["tied"] = decision.beside[at]->is_tied;
    }
    choices.push_back(std::move(json));
  }
  for (const DiskClass& disk : kDisks)
    disks.push_back({{"bytes_a_second", disk.speed},
                     {"pick_seconds", read_seconds_at(pick, disk.speed)},
                     {"best", best_at(findings, disk.speed).choice.name}});
  return {{"input", findings.input},
          {"doubts", doubts_of(findings)},
          {"goal", to_string(findings.goal)},
          {"directory", findings.directory.native()},
          {"seconds", findings.seconds},
          {"interrupted", findings.is_interrupted},
          {"raw_bytes", findings.raw_bytes},
          {"block_bytes", findings.block_bytes},
          {"finest_level", findings.finest_level},
          {"surroundings", instrument::to_json(findings.surroundings)},
          {"sample", {{"bytes", findings.sample.bytes}}},
          {"choices", std::move(choices)},
          {"other_disks_by_formula", std::move(disks)},
          {"pick", pick.choice.name},
          {"advice", advice_text(findings, decision)},
          {"command", advised_command(findings, decision)}};
}

std::string to_html(const TuneFindings& findings, const Decision& decision,
                    const std::string& about) {
  instrument::Page page{fmt::format("plait tune {}", findings.input), about};
  page.add(instrument::Verdict{advice_text(findings, decision), instrument::Tone::kGood});
  page.add(instrument::Paragraph{method_text(findings)});
  page.add(instrument::List{doubts_of(findings), instrument::Tone::kDoubt});
  instrument::ScatterPlot plot{
      {"Bytes and seconds", "Down and to the left is better; the pick is filled and named."},
      {"stored", "B"},
      {"full read", "s"},
      {}};
  for (std::size_t at = 0; at < findings.choices.size(); ++at) {
    const Measured& one = findings.choices[at];
    if (one.runs.empty()) continue;
    const bool is_pick = at == decision.pick;
    const Estimate read = estimate(one, &CopyRun::read_seconds);
    plot.points.push_back({is_pick ? "the pick" : "others",
                           (is_pick ? "pick: " : "") + one.choice.name, one.stored_bytes(),
                           read.value, is_pick, read.low, read.high});
  }
  page.add(std::move(plot));
  page.add(table_of(findings, decision));
  page.add(instrument::Command{advised_command(findings, decision)});
  return to_html(page);
}

}  // namespace plait::tune
