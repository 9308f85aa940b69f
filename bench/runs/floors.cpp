#include "runs/floors.h"

#include <fmt/format.h>

#include <algorithm>

#include "instrument/disk.h"
#include "instrument/page.h"
#include "instrument/process.h"
#include "instrument/statistics.h"
#include "plait/error.h"
#include "runs/read_runs.h"

namespace plait::bench {

namespace fs = std::filesystem;
using instrument::FloorKind;
using instrument::FloorRequest;
using instrument::FloorResult;

const RoundFloor& RoundFloors::floor(const FloorRequest& request,
                                     const instrument::MemoryLimit* limit) {
  const std::string key =
      fmt::format("{} {} {} {} {} {} {}", request.directory.native(),
                  instrument::to_string(request.kind), request.bytes, request.block_bytes,
                  request.direct, request.threads, limit == nullptr ? 0 : limit->bytes());
  auto at = floors_.find(key);
  if (at == floors_.end()) at = floors_.emplace(key, measure(request, limit)).first;
  return at->second;
}

RoundFloor RoundFloors::measure(const FloorRequest& request,
                                const instrument::MemoryLimit* limit) const {
  if (request.kind != FloorKind::kWrite)
    instrument::in_own_process([&]() -> nlohmann::json {
      const fs::path file = request.directory / "plait-bench.floor";
      const std::uint64_t bytes = std::max(request.bytes, request.file_bytes);
      if (!fs::exists(file) || fs::file_size(file) < bytes) prepare_floor_file(request);
      return true;
    });
  const auto in_limit = [&](const std::function<nlohmann::json()>& work) {
    return instrument::run_in_own_process(work, limit).result;
  };
  const auto once = [&] {
    return in_limit([&]() -> nlohmann::json { return own_floor(request); }).get<FloorResult>();
  };
  RoundFloor floor{once()};
  if (!is_first_) return floor;
  if (request.kind == FloorKind::kRead) floor.second_cold = floor.own.seconds / once().seconds;
  if (!fio_ || !instrument::have_fio()) return floor;
  const nlohmann::json by_fio = in_limit([&]() -> nlohmann::json {
    const auto result = fio_floor(request);
    return result ? nlohmann::json(*result) : nullptr;
  });
  if (by_fio.is_object()) floor.by_fio = by_fio.get<FloorResult>();
  return floor;
}

namespace {

constexpr int kFloorRounds = 5;

/// A floor in all rounds, in bytes a second.
struct Rates {
  FloorRequest request;
  std::vector<double> own = {}, fio = {};
  std::string method = {}, failure = {};
};

nlohmann::ordered_json json_of(const std::vector<double>& rates) {
  if (rates.empty()) return nullptr;
  const instrument::Estimate found = instrument::geometric_interval(rates);
  return {{"bytes_per_second", found.value},
          {"low", found.low},
          {"high", found.high},
          {"least", std::ranges::min(rates)},
          {"most", std::ranges::max(rates)},
          {"rounds", rates.size()}};
}

/// Whether fio's rates, paired by round, are within a tenth; null if nothing is known.
nlohmann::ordered_json agreement(const Rates& rates) {
  if (rates.fio.size() != rates.own.size() || rates.own.empty()) return nullptr;
  const instrument::Estimate factor = instrument::compare_paired(rates.own, rates.fio).factor;
  return factor.low <= 1.1 && factor.high >= 1 / 1.1;
}

}  // namespace

std::vector<nlohmann::ordered_json> measure_floors(const fs::path& directory, std::uint64_t bytes,
                                                   std::uint64_t block_bytes, bool fio,
                                                   const std::function<void()>& before_each) {
  std::vector<Rates> all;
  for (const FloorKind kind :
       {FloorKind::kWrite, FloorKind::kRead, FloorKind::kRandomRead, FloorKind::kUpdate})
    for (const bool direct : {false, true})
      all.push_back(Rates{.request = {.directory = directory,
                                      .kind = kind,
                                      .bytes = bytes,
                                      .block_bytes = block_bytes,
                                      .direct = direct}});
  // Round by round, so that a disk that becomes slow does so for all.
  RoundFloors round_floors(fio);
  for (int round = 0; round < kFloorRounds; ++round) {
    round_floors.begin_round(0);  // fio measures in first rounds
    for (Rates& rates : all) {
      before_each();
      if (!rates.failure.empty()) continue;
      try {
        const RoundFloor& found = round_floors.floor(rates.request, nullptr);
        rates.own.push_back(found.own.bytes_per_second());
        rates.method = found.own.method;
        if (found.by_fio) rates.fio.push_back(found.by_fio->bytes_per_second());
      } catch (const Error& error) {
        rates.failure = error.what();
      }
    }
  }
  instrument::remove_floor_files(directory);
  const std::string disk = instrument::disk_facts(directory).name();
  std::vector<nlohmann::ordered_json> floors;
  floors.reserve(all.size());
  for (const Rates& rates : all)
    floors.push_back({{"disk", disk},
                      {"kind", instrument::to_string(rates.request.kind)},
                      {"direct", rates.request.direct},
                      {"own", json_of(rates.own)},
                      {"fio", json_of(rates.fio)},
                      {"agree", agreement(rates)},
                      {"method", rates.method},
                      {"failure", or_null(!rates.failure.empty(), rates.failure)}});
  return floors;
}

std::string floor_table(const std::vector<nlohmann::ordered_json>& floors) {
  const auto megabytes = [](const nlohmann::ordered_json& rates, const char* name) {
    return rates.is_object() ? fmt::format("{:.0f}", 1e-6 * rates[name].get<double>())
                             : std::string("-");
  };
  instrument::Table table =
      instrument::table_with("disk|floor|#MB/s|#of five rounds|#fio MB/s|how|doubt");
  for (const nlohmann::ordered_json& floor : floors) {
    const nlohmann::ordered_json& own = floor["own"];
    const std::string doubt = floor["failure"].is_string() ? floor["failure"].get<std::string>()
                              : floor["agree"] == false    ? "fio differs by more than a tenth"
                                                           : "";
    table.rows.push_back(
        {{floor["disk"].get<std::string>(),
          floor["kind"].get<std::string>() + (floor["direct"] == true ? ", direct" : ""),
          megabytes(own, "bytes_per_second"),
          megabytes(own, "least") + " to " + megabytes(own, "most"),
          megabytes(floor["fio"], "bytes_per_second"), floor["method"].get<std::string>(), doubt}});
  }
  return to_text(table);
}

}  // namespace plait::bench
