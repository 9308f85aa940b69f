#include "backends/findings_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/page_parts.h"

namespace plait::bench {
namespace {

using instrument::Tone;

std::string subtitle(const RunSet& set, const Findings& findings) {
  std::string first;
  std::string last;
  for (const MeasuredRun& run : set.runs) {
    if (run.started.empty()) continue;
    if (first.empty() || run.started < first) first = run.started;
    last = std::max(last, run.started);
  }
  std::string text = fmt::format("{} runs of {} cells", set.runs.size(), findings.cells.size());
  const auto add = [&](const char* name) {
    const auto& environment = set.runs.front().environment;
    if (const auto found = environment.find(name); found != environment.end())
      text += " · " + found->second;
  };
  add("processor");
  add("kernel");
  add("plait");
  if (!first.empty()) text += " · " + first + (first == last ? "" : " to " + last);
  return text;
}

}  // namespace

std::string to_page(const RunSet& set, const Findings& findings, const std::string& command) {
  instrument::HtmlPage page("plait bench", subtitle(set, findings));
  page.verdict(findings.verdict, findings.failed     ? Tone::kFailed
                                 : findings.doubtful ? Tone::kDoubt
                                                     : Tone::kGood);
  const PageParts parts{set, findings, command, page};
  write_matrix(parts);
  if (findings.doubtful) {
    page.section("Doubts");
    page.list(findings.doubts, findings.failed ? Tone::kFailed : Tone::kDoubt);
  }
  const std::pair<const char*, void (*)(const PageParts&)> sections[] = {
      {"Ratio to the floor", write_ratios},
      {"Latency", write_latencies},
      {"Time and bytes", write_splits},
      {"Environment", write_environment}};
  for (const auto& [heading, write] : sections) {
    page.section(heading);
    write(parts);
  }
  page.embed("report", to_json(set, findings));
  return page.html();
}

}  // namespace plait::bench
