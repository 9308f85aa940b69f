// One record as a run. Each member is asked for with the type that it must have, because somebody
// else may have written it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "backends/read_runs.h"

namespace plait::bench {
namespace {

using nlohmann::json;
using Number = std::optional<double>;

/// The value at "bytes/needed_read", with the last name; null if it or what is around it is absent.
std::pair<const json&, std::string> value_at(const json& record, std::string_view path) {
  static const json kAbsent;
  const json* at = &record;
  for (;;) {
    const std::size_t slash = path.find('/');
    std::string name(path.substr(0, slash));
    if (at->is_null()) return {kAbsent, std::string(path.substr(path.rfind('/') + 1))};
    if (!at->is_object())
      throw BadRecord{
          fmt::format("expected an object around '{}', found {}", name, at->type_name())};
    const auto found = at->find(name);
    if (found == at->end()) return {kAbsent, std::move(name)};
    if (slash == std::string_view::npos) return {*found, std::move(name)};
    at = &*found;
    path.remove_prefix(slash + 1);
  }
}

/// Empty if it is absent; cut to kMostText bytes.
std::string text_at(const json& record, std::string_view path) {
  const auto& [value, name] = value_at(record, path);
  if (value.is_null()) return {};
  if (!value.is_string())
    throw BadRecord{fmt::format("'{}': expected text, found {}", name, value.type_name())};
  return cut(value.get<std::string>());
}

/// Finite, and at least 0.
Number number_at(const json& record, std::string_view path) {
  const auto& [value, name] = value_at(record, path);
  if (value.is_null()) return {};
  if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() < 0)
    throw BadRecord{fmt::format("'{}': expected a number of at least 0, found {}", name,
                                value.is_number() ? "another number" : value.type_name())};
  return value.get<double>();
}

std::optional<bool> truth_at(const json& record, std::string_view path) {
  const auto& [value, name] = value_at(record, path);
  if (value.is_null()) return {};
  if (!value.is_boolean())
    throw BadRecord{fmt::format("'{}': expected true or false, found {}", name, value.type_name())};
  return value.get<bool>();
}

Number sum_at(const json& record, std::string_view first, std::string_view second) {
  const Number a = number_at(record, first), b = number_at(record, second);
  return a || b ? Number(a.value_or(0) + b.value_or(0)) : std::nullopt;
}

constexpr std::pair<const char*, Number MeasuredCell::*> kNumbersOfCell[] = {
    {"vertices", &MeasuredCell::vertices}, {"levels", &MeasuredCell::levels},
    {"memory", &MeasuredCell::memory},     {"budget", &MeasuredCell::budget},
    {"ratio", &MeasuredCell::ratio},       {"block_bytes", &MeasuredCell::block_bytes},
    {"threads", &MeasuredCell::threads},   {"rate", &MeasuredCell::rate}};
constexpr std::pair<const char*, std::string MeasuredCell::*> kTextsOfCell[] = {
    {"backend", &MeasuredCell::backend},
    {"pipeline", &MeasuredCell::pipeline},
    {"disk", &MeasuredCell::disk},
    {"workload", &MeasuredCell::workload},
    {"mesh", &MeasuredCell::mesh}};
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

}  // namespace

std::string cut(std::string text) {
  if (text.size() <= kMostText) return text;
  std::size_t end = kMostText;
  // A byte 10xxxxxx continues a character.
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  return text + "…";
}

MeasuredRun run_of_record(const json& record) {
  if (!record.is_object()) throw BadRecord{"expected an object"};
  const std::string format = text_at(record, "format");
  if (format != "plait-bench-1")
    throw BadRecord{fmt::format("expected the format plait-bench-1, found '{}'", format)};
  MeasuredRun run;
  const json& key = value_at(record, "key").first;
  if (!key.is_string() || key.get_ref<const std::string&>().size() > 4096)
    throw BadRecord{"'key': expected text of at most 4096 bytes"};
  run.key = key.get<std::string>();
  run.cell = cell_of(value_at(record, "cell").first);
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
  run.process_moved = sum_at(record, "bytes/process_read", "bytes/process_written");
  run.limit_held = truth_at(record, "proofs/limit/held");
  run.checksums = truth_at(record, "proofs/checksums");
  const json& doubts = value_at(record, "doubts").first;
  if (!doubts.is_null() && !doubts.is_array()) throw BadRecord{"'doubts': expected a list"};
  for (const json& doubt : doubts) {
    if (!doubt.is_string()) throw BadRecord{"'doubts': expected lines of text"};
    if (run.doubts.size() < 20) run.doubts.push_back(cut(doubt.get<std::string>()));
  }
  read_environment(value_at(record, "environment").first, "", run.environment);
  return run;
}

}  // namespace plait::bench
