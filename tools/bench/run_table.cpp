#include "bench/run_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>

#include "bench/record_file.h"
#include "instrument/statistics.h"
#include "plait/byte_text.h"

namespace plait::bench {
namespace {

using Json = nlohmann::ordered_json;

struct Row {  // NOLINT(bugprone-exception-escape): moving JSON does not throw
  Json cell;
  std::vector<double> seconds, ratios, rates, floor_rates, p99;
  std::set<std::string> labels, doubts;
  int failed = 0;
};

std::vector<Row> rows_of(const std::vector<Json>& records) {
  std::vector<Row> rows;
  std::map<std::string, std::size_t> places;
  for (const Json& record : records) {
    const auto [at, is_new] = places.try_emplace(record["key"].get<std::string>(), rows.size());
    if (is_new) rows.emplace_back().cell = record["cell"];
    Row& row = rows[at->second];
    if (record["outcome"] != "ok") {
      ++row.failed;
      row.doubts.insert(record["failure"].is_string() ? record["failure"].get<std::string>()
                                                      : "failed");
      continue;
    }
    const double seconds = record["seconds"].get<double>();
    row.seconds.push_back(seconds);
    if (record["ratio"].is_number()) row.ratios.push_back(record["ratio"].get<double>());
    const double needed = record["bytes"]["needed_read"].get<double>() +
                          record["bytes"]["needed_written"].get<double>();
    row.rates.push_back(needed / seconds);
    if (record["floor"].is_object())
      row.floor_rates.push_back((record["floor"]["bytes_read"].get<double>() +
                                 record["floor"]["bytes_written"].get<double>()) /
                                record["floor"]["seconds"].get<double>());
    if (record["latencies"].is_object())
      row.p99.push_back(record["latencies"]["p99"].get<double>());
    const Json& cold = record["proofs"]["cold"];
    row.labels.insert(cold.is_object() ? cold["label"].get<std::string>() : "new");
    for (const Json& doubt : record["doubts"]) row.doubts.insert(doubt.get<std::string>());
  }
  return rows;
}

std::string rate_text(const std::vector<double>& rates) {
  return rates.empty() ? "-" : fmt::format("{:.0f}", 1e-6 * instrument::median(rates));
}

std::string ratio_text(const Row& row) {
  if (row.ratios.empty()) return row.seconds.empty() ? "FAILED" : "-";
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", instrument::median(row.ratios),
                     std::ranges::min(row.ratios), std::ranges::max(row.ratios));
}

}  // namespace

std::string run_table(const std::vector<Json>& records) {
  std::string text =
      "| times the floor | disk | backend | workload | size | memory | MB/s | floor MB/s | p99 | "
      "cache | runs |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  std::set<std::string> doubts;
  for (const Row& row : rows_of(records)) {
    std::string labels;
    for (const std::string& label : row.labels) labels += (labels.empty() ? "" : ", ") + label;
    const std::string pipeline = row.cell["pipeline"].get<std::string>();
    text += fmt::format(
        "| {} | {} | {}{} | {} | {} | {} | {} | {} | {} | {} | {} |\n", ratio_text(row),
        row.cell["disk"].get<std::string>(), row.cell["backend"].get<std::string>(),
        pipeline == "none" ? "" : " " + pipeline, row.cell["workload"].get<std::string>(),
        format_bytes(row.cell["vertices"].get<std::uint64_t>() * 12),
        format_bytes(row.cell["memory"].get<std::uint64_t>()), rate_text(row.rates),
        rate_text(row.floor_rates),
        row.p99.empty() ? "-" : fmt::format("{:.2f} ms", 1e3 * instrument::median(row.p99)), labels,
        row.seconds.size() + static_cast<std::size_t>(row.failed));
    for (const std::string& doubt : row.doubts)
      doubts.insert(fmt::format("{} {}: {}", row.cell["backend"].get<std::string>(),
                                row.cell["workload"].get<std::string>(), doubt));
  }
  for (const std::string& doubt : doubts) text += fmt::format("doubt: {}\n", doubt);
  return text;
}

std::string verdict(const std::vector<Json>& records) {
  const std::vector<std::string> different = different_digests(records);
  if (!different.empty())
    return fmt::format("FAILED: backends gave different data: {}\n", different.front());
  struct Candidate {
    std::string name;
    instrument::Estimate seconds;
  };
  std::map<std::string, std::vector<Candidate>> groups;
  for (const Row& row : rows_of(records)) {
    if (row.seconds.empty() || row.labels.contains("warm")) continue;
    const std::string pipeline = row.cell["pipeline"].get<std::string>();
    groups[fmt::format("{} on {}, {}", row.cell["workload"].get<std::string>(),
                       row.cell["disk"].get<std::string>(),
                       format_bytes(row.cell["vertices"].get<std::uint64_t>() * 12))]
        .push_back(
            {row.cell["backend"].get<std::string>() + (pipeline == "none" ? "" : " " + pipeline),
             instrument::median_interval(row.seconds)});
  }
  std::string text;
  for (auto& [group, candidates] : groups) {
    std::ranges::sort(candidates, {}, [](const Candidate& one) { return one.seconds.value; });
    const bool decided = candidates.size() > 1 && candidates[0].seconds.count >= 5 &&
                         !candidates[0].seconds.overlaps(candidates[1].seconds);
    text += fmt::format(
        "{}{}: {}", text.empty() ? "" : "; ", group,
        decided ? candidates[0].name
        : candidates.size() > 1
            ? fmt::format("undecided between {} and {}", candidates[0].name, candidates[1].name)
            : candidates[0].name + " alone");
  }
  return text.empty() ? "no cold figure, so no verdict\n" : "fastest: " + text + ".\n";
}

}  // namespace plait::bench
