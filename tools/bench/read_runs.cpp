#include "bench/read_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "plait/error.h"
#include "plait/file.h"

namespace plait::bench {
namespace {

using nlohmann::json;

constexpr std::size_t kMostSkippedLines = 10;

struct BadRecord {
  std::string why;
};

/// The member `name` of an object; null if either is absent.
const json& member(const json& object, const char* name) {
  static const json kAbsent;
  if (!object.is_object()) {
    if (object.is_null()) return kAbsent;
    throw BadRecord{
        fmt::format("expected an object around '{}', found {}", name, object.type_name())};
  }
  const auto at = object.find(name);
  return at == object.end() ? kAbsent : *at;
}

/// Long text is cut between characters: a byte 10xxxxxx continues a character.
std::string cut(std::string text) {
  if (text.size() <= kMostText) return text;
  std::size_t end = kMostText;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "…";
}

std::string text_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_string())
    throw BadRecord{fmt::format("'{}': expected text, found {}", name, value.type_name())};
  return cut(value.get<std::string>());
}

std::optional<double> number_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() < 0)
    throw BadRecord{fmt::format("'{}': expected a number of at least 0, found {}", name,
                                value.is_number() ? "another number" : value.type_name())};
  return value.get<double>();
}

std::optional<bool> truth_of(const json& object, const char* name) {
  const json& value = member(object, name);
  if (value.is_null()) return {};
  if (!value.is_boolean())
    throw BadRecord{fmt::format("'{}': expected true or false, found {}", name, value.type_name())};
  return value.get<bool>();
}

std::vector<double> numbers_of(const json& object, const char* name) {
  const json& list = member(object, name);
  if (list.is_null()) return {};
  if (!list.is_array()) throw BadRecord{fmt::format("'{}': expected a list of numbers", name)};
  std::vector<double> values;
  values.reserve(list.size());
  for (const json& value : list) {
    if (!value.is_number() || !std::isfinite(value.get<double>()))
      throw BadRecord{fmt::format("'{}': expected a list of numbers", name)};
    values.push_back(value.get<double>());
  }
  return values;
}

/// Joins neighbouring bins until there are few.
void merge_bins(std::vector<double>& edges, std::vector<double>& counts) {
  while (counts.size() > kMostSamples) {
    std::vector<double> fewer_edges;
    std::vector<double> fewer_counts;
    for (std::size_t at = 0; at < counts.size(); at += 2) {
      fewer_edges.push_back(edges[at]);
      fewer_counts.push_back(counts[at] + (at + 1 < counts.size() ? counts[at + 1] : 0));
    }
    fewer_edges.push_back(edges.back());
    edges = std::move(fewer_edges);
    counts = std::move(fewer_counts);
  }
}

void read_latencies(const json& record, MeasuredRun& run) {
  const json& latencies = member(record, "latencies");
  run.requests = number_of(latencies, "count");
  run.p50 = number_of(latencies, "p50");
  run.p90 = number_of(latencies, "p90");
  run.p99 = number_of(latencies, "p99");
  run.p999 = number_of(latencies, "p999");
  run.longest = number_of(latencies, "max");
  const json& histogram = member(latencies, "histogram");
  run.latency_edges = numbers_of(histogram, "edges");
  run.latency_counts = numbers_of(histogram, "counts");
  const bool empty = run.latency_edges.empty() && run.latency_counts.empty();
  if (!empty && run.latency_edges.size() != run.latency_counts.size() + 1)
    throw BadRecord{"'histogram': expected one edge more than counts"};
  if (!std::is_sorted(run.latency_edges.begin(), run.latency_edges.end()))
    throw BadRecord{"'edges': expected rising numbers"};
  if (std::any_of(run.latency_counts.begin(), run.latency_counts.end(),
                  [](double n) { return n < 0; }))
    throw BadRecord{"'counts': expected numbers of at least 0"};
  if (!empty) merge_bins(run.latency_edges, run.latency_counts);
}

void read_throughput(const json& record, MeasuredRun& run) {
  const json& throughput = member(record, "throughput");
  const std::vector<double> seconds = numbers_of(throughput, "seconds");
  const std::vector<double> bytes = numbers_of(throughput, "bytes");
  if (seconds.size() != bytes.size())
    throw BadRecord{"'throughput': expected as many seconds as bytes"};
  const std::size_t stride = (seconds.size() + kMostSamples - 1) / kMostSamples;
  for (std::size_t at = 0; at < seconds.size(); at += std::max<std::size_t>(1, stride)) {
    run.throughput_seconds.push_back(seconds[at]);
    run.throughput_bytes.push_back(bytes[at]);
  }
}

void read_environment(const json& value, const std::string& prefix,
                      std::map<std::string, std::string>& environment) {
  if (!value.is_object()) return;
  for (const auto& [name, item] : value.items()) {
    if (environment.size() >= 60) return;
    if (item.is_object() && prefix.empty())
      read_environment(item, cut(name) + ".", environment);
    else if (item.is_string())
      environment[prefix + cut(name)] = cut(item.get<std::string>());
    else if (item.is_number() || item.is_boolean())
      environment[prefix + cut(name)] = item.dump();
  }
}

MeasuredCell cell_of(const json& value) {
  if (!value.is_object()) throw BadRecord{"'cell': expected an object"};
  MeasuredCell cell;
  cell.backend = text_of(value, "backend");
  cell.pipeline = text_of(value, "pipeline");
  cell.disk = text_of(value, "disk");
  cell.directory = text_of(value, "directory");
  cell.workload = text_of(value, "workload");
  cell.vertices = number_of(value, "vertices");
  cell.levels = number_of(value, "levels");
  cell.memory = number_of(value, "memory");
  cell.budget = number_of(value, "budget");
  cell.ratio = number_of(value, "ratio");
  cell.block_bytes = number_of(value, "block_bytes");
  cell.threads = number_of(value, "threads");
  cell.rate = number_of(value, "rate");
  cell.durable = truth_of(value, "durable").value_or(false);
  if (cell.backend.empty() || cell.workload.empty())
    throw BadRecord{"'cell': expected a backend and a workload"};
  return cell;
}

void read_proofs(const json& record, MeasuredRun& run) {
  const json& proofs = member(record, "proofs");
  const json& limit = member(proofs, "limit");
  run.limit_bytes = number_of(limit, "bytes");
  run.limit_held = truth_of(limit, "held");
  run.label = text_of(member(proofs, "cold"), "label");
  run.second_cold = number_of(proofs, "second_cold");
  run.checksums = truth_of(proofs, "checksums");
  const json& others = member(proofs, "others");
  run.others_read = number_of(others, "device_read");
  run.others_written = number_of(others, "device_written");
}

MeasuredRun run_of(const json& record) {
  if (!record.is_object()) throw BadRecord{"expected an object"};
  const std::string format = text_of(record, "format");
  if (format != "plait-bench-1")
    throw BadRecord{fmt::format("expected the format plait-bench-1, found '{}'", format)};
  MeasuredRun run;
  const json& key = member(record, "key");
  if (!key.is_string() || key.get_ref<const std::string&>().size() > 4096)
    throw BadRecord{"'key': expected text of at most 4096 bytes"};
  run.key = key.get<std::string>();
  run.cell = cell_of(member(record, "cell"));
  run.round = static_cast<std::uint64_t>(std::min(number_of(record, "round").value_or(0), 1e15));
  run.started = text_of(record, "started");
  run.failure = text_of(record, "failure");
  const std::string outcome = text_of(record, "outcome");
  if (outcome != "ok" && outcome != "failed")
    throw BadRecord{fmt::format("'outcome': expected ok or failed, found '{}'", outcome)};
  run.ok = outcome == "ok";
  run.seconds = number_of(record, "seconds").value_or(0);
  if (run.ok && !(run.seconds > 0)) throw BadRecord{"'seconds': expected a number over 0"};
  const json& floor = member(record, "floor");
  run.floor_seconds = number_of(floor, "seconds");
  run.floor_method = text_of(floor, "method");
  run.fio_seconds = number_of(member(record, "floor_by_fio"), "seconds");
  run.ratio = number_of(record, "ratio");
  if (run.ratio && !(*run.ratio > 0)) throw BadRecord{"'ratio': expected a number over 0"};

  const json& bytes = member(record, "bytes");
  run.needed_read = number_of(bytes, "needed_read");
  run.needed_written = number_of(bytes, "needed_written");
  run.moved_read = number_of(bytes, "moved_read");
  run.moved_written = number_of(bytes, "moved_written");
  run.device_read = number_of(bytes, "device_read");
  run.device_written = number_of(bytes, "device_written");
  run.stored = number_of(bytes, "stored");
  const json& split = member(record, "split");
  run.compute = number_of(split, "compute");
  run.wait = number_of(split, "wait");
  run.codec = number_of(split, "codec");
  run.sync = number_of(split, "sync");
  read_latencies(record, run);
  read_throughput(record, run);
  run.minor_faults = number_of(member(record, "faults"), "minor");
  run.major_faults = number_of(member(record, "faults"), "major");
  run.peak_rss = number_of(record, "peak_rss");
  run.user_seconds = number_of(member(record, "processor"), "user");
  run.system_seconds = number_of(member(record, "processor"), "system");
  read_proofs(record, run);
  run.digest_of = text_of(member(record, "digest"), "of");
  run.digest = text_of(member(record, "digest"), "value");
  const json& doubts = member(record, "doubts");
  if (!doubts.is_null() && !doubts.is_array()) throw BadRecord{"'doubts': expected a list"};
  for (const json& doubt : doubts) {
    if (!doubt.is_string()) throw BadRecord{"'doubts': expected lines of text"};
    if (run.doubts.size() < 20) run.doubts.push_back(cut(doubt.get<std::string>()));
  }
  read_environment(member(record, "environment"), "", run.environment);
  return run;
}

/// The lines of a file, one at a time. A line that is too long is passed over.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path)
      : file_(path, OpenMode::kRead), left_(file_.size()), buffer_(1 << 18, '\0') {}

  /// Returns false at the end. `complete`: a newline ended it; `too_long`: `line` is only its
  /// start.
  bool next(std::string& line, bool& complete, bool& too_long) {
    line.clear();
    complete = too_long = false;
    bool any = false;
    for (;;) {
      if (at_ == end_ && !fill()) return any;
      any = true;
      const char* const first = buffer_.data() + at_;
      const std::size_t available = end_ - at_;
      const auto* const newline = std::find(first, first + available, '\n');
      const auto length = static_cast<std::size_t>(newline - first);
      if (line.size() + length > kMostLineBytes) too_long = true;
      if (!too_long) line.append(first, length);
      at_ += length;
      if (length == available) continue;
      ++at_;
      complete = true;
      return true;
    }
  }

 private:
  bool fill() {
    at_ = 0;
    end_ = static_cast<std::size_t>(std::min<std::uint64_t>(left_, buffer_.size()));
    if (end_ == 0) return false;
    file_.read_at(offset_, std::as_writable_bytes(std::span(buffer_).first(end_)));
    offset_ += end_;
    left_ -= end_;
    return true;
  }

  File file_;
  std::uint64_t offset_ = 0, left_;
  std::string buffer_;
  std::size_t at_ = 0, end_ = 0;
};

}  // namespace

RunSet read_runs(const std::vector<std::filesystem::path>& files) {
  RunSet set;
  std::unordered_map<std::string, std::size_t> runs_of_cell;
  for (const std::filesystem::path& path : files) {
    Lines lines(path);
    std::string line;
    bool complete = false;
    bool too_long = false;
    for (std::uint64_t number = 1; lines.next(line, complete, too_long); ++number) {
      if (complete && !too_long && line.find_first_not_of(" \t\r") == std::string::npos) continue;
      try {
        if (too_long)
          throw BadRecord{fmt::format("expected at most {} bytes in a line", kMostLineBytes)};
        if (!complete) throw BadRecord{"the line is not complete: its writer was stopped"};
        MeasuredRun run = run_of(json::parse(line));
        if (set.runs.size() == kMostRuns)
          throw BadRecord{fmt::format("expected at most {} runs", kMostRuns)};
        if (++runs_of_cell[run.key] > kMostRunsOfCell)
          throw BadRecord{fmt::format("expected at most {} runs of a cell", kMostRunsOfCell)};
        run.file = cut(path.native());
        run.line = number;
        set.runs.push_back(std::move(run));
      } catch (const BadRecord& bad) {
        ++set.skipped;
        if (set.skipped_lines.size() < kMostSkippedLines)
          set.skipped_lines.push_back(
              fmt::format("{}:{}: {}", cut(path.native()), number, bad.why));
      } catch (const json::exception&) {
        ++set.skipped;
        if (set.skipped_lines.size() < kMostSkippedLines)
          set.skipped_lines.push_back(fmt::format("{}:{}: not JSON", cut(path.native()), number));
      }
    }
  }
  if (set.runs.empty()) {
    const std::string place =
        set.skipped_lines.empty()
            ? (files.empty() ? std::string()
                             : files.front().native() + ": expected runs, found none")
            : set.skipped_lines.front();
    throw Error(ErrorCode::kInvalidArgument, fmt::format("read {}", place));
  }
  return set;
}

RunSet runs_of(const std::vector<nlohmann::ordered_json>& records, const std::string& name) {
  RunSet set;
  for (const nlohmann::ordered_json& record : records) {
    try {
      set.runs.push_back(run_of(json::parse(record.dump())));
    } catch (const BadRecord& bad) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}:{}: {}", name, set.runs.size() + 1, bad.why));
    }
    set.runs.back().file = name;
    set.runs.back().line = set.runs.size();
  }
  return set;
}

}  // namespace plait::bench
