#include "runs/read_runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <type_traits>

#include "plait/error.h"

namespace plait::bench {
namespace {

using nlohmann::json;
using Number = std::optional<double>;

constexpr std::size_t kMostSkippedLines = 10;
constexpr std::size_t kMostText = 200;  ///< bytes of a name; longer ones are cut

/// A record that cannot be believed.
struct BadRecord {
  std::string why;
};

/// Long text is cut between characters.
std::string cut(std::string text) {
  if (text.size() <= kMostText) return text;
  std::size_t end = kMostText;
  // A byte 10xxxxxx continues a character.
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "…";
}

/// Null if the value or what is around it is absent.
const json& value_at(const json& record, const json::json_pointer& place) {
  static const json kAbsent;
  if (place.empty()) return record;
  const json& around = value_at(record, place.parent_pointer());
  if (around.is_null()) return kAbsent;
  if (!around.is_object())
    throw BadRecord{
        fmt::format("expected an object around '{}', found {}", place.back(), around.type_name())};
  const auto found = around.find(place.back());
  return found == around.end() ? kAbsent : *found;
}

/// The value at "bytes/needed_read"; empty if it is absent.
template <class Value>
std::optional<Value> member_at(const json& record, const std::string& path, const char* expected,
                               bool (*fits)(const json&)) {
  const json::json_pointer place("/" + path);
  const json& value = value_at(record, place);
  if (value.is_null()) return {};
  if (!fits(value))
    throw BadRecord{fmt::format(
        "'{}': expected {}, found {}", place.back(), expected,
        value.is_number() && std::is_same_v<Value, double> ? "another number" : value.type_name())};
  return value.get<Value>();
}

/// Empty if it is absent; cut to kMostText bytes.
std::string text_at(const json& record, const std::string& path) {
  return cut(member_at<std::string>(record, path, "text", [](const json& value) {
               return value.is_string();
             }).value_or(""));
}

/// Finite, and at least 0.
Number number_at(const json& record, const std::string& path) {
  return member_at<double>(record, path, "a number of at least 0", [](const json& value) {
    return value.is_number() && std::isfinite(value.get<double>()) && value.get<double>() >= 0;
  });
}

std::optional<bool> truth_at(const json& record, const std::string& path) {
  return member_at<bool>(record, path, "true or false",
                         [](const json& value) { return value.is_boolean(); });
}

Number sum_at(const json& record, const std::string& first, const std::string& second) {
  const Number a = number_at(record, first), b = number_at(record, second);
  return a || b ? Number(a.value_or(0) + b.value_or(0)) : std::nullopt;
}

constexpr std::pair<const char*, Number MeasuredRun::*> kNumbers[] = {
    {"repetitions", &MeasuredRun::repetitions},
    {"floor/seconds", &MeasuredRun::floor_seconds},
    {"floor_by_fio/seconds", &MeasuredRun::fio_seconds},
    {"ratio", &MeasuredRun::ratio},
    {"bytes/needed_read", &MeasuredRun::needed_read},
    {"bytes/needed_written", &MeasuredRun::needed_written},
    {"bytes/moved_read", &MeasuredRun::moved_read},
    {"bytes/moved_written", &MeasuredRun::moved_written},
    {"bytes/device_read", &MeasuredRun::device_read},
    {"bytes/device_written", &MeasuredRun::device_written},
    {"split/compute", &MeasuredRun::compute},
    {"split/wait", &MeasuredRun::wait},
    {"split/codec", &MeasuredRun::codec},
    {"split/sync", &MeasuredRun::sync},
    {"latencies/p50", &MeasuredRun::p50},
    {"latencies/p99", &MeasuredRun::p99},
    {"latencies/p999", &MeasuredRun::p999},
    {"surroundings/others", &MeasuredRun::others_busy},
    {"surroundings/stolen", &MeasuredRun::stolen},
    {"proofs/limit/bytes", &MeasuredRun::limit_bytes},
    {"proofs/second_cold", &MeasuredRun::second_cold},
    {"proofs/others/device_read", &MeasuredRun::others_read},
    {"proofs/others/device_written", &MeasuredRun::others_written}};
constexpr std::pair<const char*, std::string MeasuredRun::*> kTexts[] = {
    {"started", &MeasuredRun::started},
    {"failure", &MeasuredRun::failure},
    {"proofs/limit/why_not", &MeasuredRun::limit_why_not},
    {"proofs/cold/label", &MeasuredRun::label},
    {"proofs/cold/why", &MeasuredRun::why_warm},
    {"digest/of", &MeasuredRun::digest_of},
    {"digest/value", &MeasuredRun::digest}};

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
  for (const auto& [path, member] : kTextsOfCell) cell.*member = text_at(value, path);
  for (const auto& [path, member] : kNumbersOfCell) cell.*member = number_at(value, path);
  cell.durable = truth_at(value, "durable").value_or(false);
  if (cell.backend.empty() || cell.workload.empty())
    throw BadRecord{"'cell': expected a backend and a workload"};
  return cell;
}

/// Each member is asked for with the type that it must have, because somebody else may have written
/// it. The caller fills in `file` and `line`. Throws BadRecord for what is no record.
MeasuredRun run_of_record(const json& record) {
  if (!record.is_object()) throw BadRecord{"expected an object"};
  const std::string format = text_at(record, "format");
  if (format != "plait-bench-1")
    throw BadRecord{fmt::format("expected the format plait-bench-1, found '{}'", format)};
  MeasuredRun run;
  const json& key = value_at(record, json::json_pointer("/key"));
  if (!key.is_string() || key.get_ref<const std::string&>().size() > 4096)
    throw BadRecord{"'key': expected text of at most 4096 bytes"};
  run.key = key.get<std::string>();
  run.cell = cell_of(value_at(record, json::json_pointer("/cell")));
  for (const auto& [path, member] : kTexts) run.*member = text_at(record, path);
  for (const auto& [path, member] : kNumbers) run.*member = number_at(record, path);
  run.round = static_cast<std::uint64_t>(std::min(number_at(record, "round").value_or(0), 1e15));
  run.is_auto = truth_at(record, "auto").value_or(false);
  const std::string outcome = text_at(record, "outcome");
  if (outcome != "ok" && outcome != "failed")
    throw BadRecord{fmt::format("'outcome': expected ok or failed, found '{}'", outcome)};
  run.ok = outcome == "ok";
  run.seconds = number_at(record, "seconds").value_or(0);
  if (run.ok && !(run.seconds > 0)) throw BadRecord{"'seconds': expected a number over 0"};
  if (run.ratio && !(*run.ratio > 0)) throw BadRecord{"'ratio': expected a number over 0"};
  run.floor_bytes = sum_at(record, "floor/bytes_read", "floor/bytes_written");
  run.fio_bytes = sum_at(record, "floor_by_fio/bytes_read", "floor_by_fio/bytes_written");
  run.limit_held = truth_at(record, "proofs/limit/held");
  run.checksums = truth_at(record, "proofs/checksums");
  const json& doubts = value_at(record, json::json_pointer("/doubts"));
  if (!doubts.is_null() && !doubts.is_array()) throw BadRecord{"'doubts': expected a list"};
  for (const json& doubt : doubts) {
    if (!doubt.is_string()) throw BadRecord{"'doubts': expected lines of text"};
    if (run.doubts.size() < 20) run.doubts.push_back(cut(doubt.get<std::string>()));
  }
  read_environment(value_at(record, json::json_pointer("/environment")), "", run.environment);
  return run;
}

/// Calls use(text, number, why) for the lines of a file that are not empty; `why` says why a line
/// cannot be a record.
template <class Use>
void for_each_line(const std::filesystem::path& path, Use use) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw system_error("open", path.native(), errno);
  std::string buffer(kMostLineBytes + 1, '\0');
  for (std::uint64_t number = 1; !file.eof(); ++number) {
    file.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<std::size_t>(file.gcount());  // with the newline
    if (file.bad()) throw system_error("read", path.native(), EIO);
    std::string why;
    if (file.eof() && count > 0) why = "the line is not complete: its writer was stopped";
    if (file.fail() && !file.eof()) {
      why = fmt::format("expected at most {} bytes in a line", kMostLineBytes);
      file.clear();
      file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    const std::string text = buffer.substr(0, count - (why.empty() && !file.eof() ? 1 : 0));
    if (!why.empty() || text.find_first_not_of(" \t\r") != std::string::npos)
      use(text, number, why);
  }
}

}  // namespace

RunSet read_runs(const std::vector<std::filesystem::path>& files) {
  RunSet set;
  for (const std::filesystem::path& path : files)
    for_each_line(path, [&](const std::string& text, std::uint64_t number, const std::string& why) {
      try {
        if (!why.empty()) throw BadRecord{why};
        const json record = json::parse(text, nullptr, false);
        if (record.is_discarded()) throw BadRecord{"not JSON"};
        MeasuredRun run = run_of_record(record);
        if (set.runs.size() == kMostRuns)
          throw BadRecord{fmt::format("expected at most {} runs", kMostRuns)};
        run.file = cut(path.native());
        run.line = number;
        set.runs.push_back(std::move(run));
      } catch (const BadRecord& bad) {
        ++set.skipped;
        if (set.skipped_lines.size() < kMostSkippedLines)
          set.skipped_lines.push_back(
              fmt::format("{}:{}: {}", cut(path.native()), number, bad.why));
      }
    });
  if (set.runs.empty())
    throw Error(ErrorCode::kInvalidArgument,
                "read " + (set.skipped_lines.empty()
                               ? files.front().native() + ": expected runs, found none"
                               : set.skipped_lines.front()));
  return set;
}

RunSet runs_of(const std::vector<nlohmann::ordered_json>& records, const std::string& name) {
  RunSet set;
  for (const nlohmann::ordered_json& record : records) {
    try {
      set.runs.push_back(run_of_record(json::parse(record.dump())));
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
