#include "tune/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "instrument/html_page.h"

namespace plait::tune {
namespace {

using instrument::Cell;

Cell number(double value, int digits = 3) { return {fmt::format("{:.{}g}", value, digits), value}; }
Cell number(const std::optional<double>& value) {
  return value ? number(*value) : Cell("-", std::numeric_limits<double>::infinity());
}

/// Sizes of the whole attribute against the processor's time, for all trials with one block size.
instrument::ScatterPlot plot_of(const Findings& findings, const Advice& advice) {
  instrument::ScatterPlot plot;
  plot.caption = {"Size and speed of each pipeline",
                  fmt::format("Blocks of {}. To the left: smaller; up: decodes faster. The line is "
                              "the Pareto front for {}.",
                              size_argument(advice.pick.block_bytes), to_string(findings.goal)),
                  ""};
  plot.x = {"stored bytes of a raw byte", "x", instrument::Scale::kLog};
  plot.y = {"decoding, a core", "B/s", instrument::Scale::kLog};
  const Trials& trials = findings.trials;
  for (std::size_t at = 0; at < trials.trials.size(); ++at) {
    const Trial& trial = trials.trials[at];
    if (!is_measured(trial) || trial.block_bytes != advice.pick.block_bytes) continue;
    const Rates rates = rates_of(trials, trial);
    const bool front = std::ranges::any_of(advice.rows, [&](const ChoiceRow& row) {
      return row.on_front && row.choice.trials[trial.attribute] == at;
    });
    plot.points.push_back({trials.attributes[trial.attribute].schema.name, trial.pipeline,
                           rates.stored.value, 1 / rates.decode.value, front,
                           fmt::format("encodes {:.3g} GB/s a core", 1e-9 / rates.encode.value),
                           rates.stored.low, rates.stored.high, 1 / rates.decode.high,
                           1 / rates.decode.low});
  }
  return plot;
}

instrument::Table choices_table(const Findings& findings, const Advice& advice) {
  instrument::Table table;
  table.caption = {"Predicted for the whole store, on this disk",
                   "Seconds. The pick is green; a star marks the front.", ""};
  table.columns = {
      {"choice", false}, {"stored MB"},       {"ratio"},      {"read"},
      {"write"},         {"update in place"}, {"cold patch"}, {"the next is faster from, MB/s"},
      {"remarks", false}};
  for (const ChoiceRow& row : advice.rows)
    table.rows.push_back(
        {{Cell(fmt::format("{}{}", row.on_front ? "* " : "", to_text(findings.trials, row.choice))),
          number(row.stored_bytes / 1e6), number(row.ratio), number(row.seconds.read),
          number(row.seconds.write), number(row.seconds.update), number(row.seconds.patch),
          row.next_from ? number(*row.next_from / 1e6) : Cell(""),
          Cell(fmt::format(
              "{}{}", row.names,
              row.is_like_pick && !row.is_pick ? " (no difference from the pick)" : ""))},
         row.is_pick ? instrument::Tone::kGood : instrument::Tone::kPlain});
  return table;
}

instrument::Table disks_table(const Findings& findings, const Advice& advice) {
  instrument::Table table;
  table.caption = {"The pick on other disks", "Seconds, computed with this machine's processors.",
                   ""};
  table.columns = {{"disk", false},     {"read"},       {"write"},
                   {"update in place"}, {"cold patch"}, {"the best choice there", false}};
  std::vector<Disk> disks = {findings.disk.disk};
  for (const Disk& disk : classes_of_disks()) disks.push_back(disk);
  for (const Disk& disk : disks) {
    const Predicted seconds = predict(work_of(findings.trials, advice.pick),
                                      {disk, findings.processors, findings.reading});
    const Choice best =
        pick(findings.trials, findings.goal, {disk, findings.processors, findings.reading});
    table.rows.push_back(
        {{Cell(disk.name), number(seconds.read), number(seconds.write), number(seconds.update),
          number(seconds.patch),
          Cell(best == advice.pick ? "the pick" : to_text(findings.trials, best))}});
  }
  return table;
}

}  // namespace

std::string to_html(const Findings& findings, const Advice& advice) {
  instrument::HtmlPage page(
      fmt::format("plait tune {}", findings.input),
      fmt::format("goal {}, seed {}, {} rounds, {:.1f} s{}", to_string(findings.goal),
                  findings.seed, findings.rounds, findings.seconds,
                  findings.is_interrupted ? ", interrupted" : ""));
  page.verdict(advice.sentence,
               findings.is_interrupted ? instrument::Tone::kDoubt : instrument::Tone::kGood);
  page.command(advice.command);
  if (!findings.note.empty()) page.paragraph(findings.note);
  page.plot(plot_of(findings, advice));
  page.table(choices_table(findings, advice));
  page.table(disks_table(findings, advice));
  page.section("What was measured");
  page.paragraph(fmt::format(
      "{}: reads {:.3g} GB/s ({}), writes {:.3g} GB/s durably, {:.3g} ms to the first byte. {} "
      "threads get {:.2f} processors.",
      findings.disk.disk.name, findings.disk.disk.read / 1e9,
      findings.disk.is_cold ? "cold" : "from memory", findings.disk.disk.write / 1e9,
      1e3 * findings.disk.disk.latency, findings.threads, findings.processors));
  page.embed("tune", to_json(findings, advice));
  return page.html();
}

}  // namespace plait::tune
