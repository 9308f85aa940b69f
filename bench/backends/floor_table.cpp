#include "backends/floor_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "backends/round_floors.h"
#include "instrument/disk.h"
#include "instrument/page.h"
#include "instrument/statistics.h"
#include "plait/error.h"

namespace plait::bench {

using instrument::FloorKind;
using instrument::FloorRequest;

namespace {

/// Bytes a second in each round.
struct Rates {
  std::vector<double> own, fio;
  std::string method, failure;
};

nlohmann::ordered_json json_of(const std::vector<double>& rates) {
  if (rates.empty()) return nullptr;
  const instrument::Estimate found = instrument::geometric_interval(rates);
  return {{"bytes_per_second", found.value},
          {"low", found.low},
          {"high", found.high},
          {"least", *std::ranges::min_element(rates)},
          {"most", *std::ranges::max_element(rates)},
          {"rounds", rates.size()}};
}

void measure_once(const FloorRequest& request, RoundFloors& floors, Rates& rates) {
  try {
    const RoundFloor& found = floors.floor(request, nullptr);
    rates.own.push_back(found.own.bytes_per_second());
    rates.method = found.own.method;
    if (found.by_fio) rates.fio.push_back(found.by_fio->bytes_per_second());
  } catch (const Error& error) {
    rates.failure = error.what();
  }
}

/// Whether fio's rates, paired by round, are within a tenth; null if nothing is known.
nlohmann::ordered_json agreement(const Rates& rates) {
  if (rates.fio.size() != rates.own.size() || rates.own.empty()) return nullptr;
  const instrument::Estimate factor = instrument::compare_paired(rates.own, rates.fio).factor;
  return factor.low <= 1.1 && factor.high >= 1 / 1.1;
}

}  // namespace

std::vector<nlohmann::ordered_json> measure_floors(const std::filesystem::path& directory,
                                                   std::uint64_t bytes, std::uint64_t block_bytes,
                                                   bool fio,
                                                   const std::function<void()>& before_each) {
  std::vector<FloorRequest> requests;
  for (const FloorKind kind :
       {FloorKind::kWrite, FloorKind::kRead, FloorKind::kRandomRead, FloorKind::kUpdate})
    for (const bool direct : {false, true})
      requests.push_back({.directory = directory,
                          .kind = kind,
                          .bytes = bytes,
                          .block_bytes = block_bytes,
                          .direct = direct});
  // Round by round, so that a disk that becomes slow does so for all.
  std::vector<Rates> rates(requests.size());
  RoundFloors round_floors(fio);
  for (int round = 0; round < kFloorRounds; ++round) {
    round_floors.begin_round(0);  // fio measures in first rounds
    for (std::size_t at = 0; at < requests.size(); ++at) {
      before_each();
      if (rates[at].failure.empty()) measure_once(requests[at], round_floors, rates[at]);
    }
  }
  instrument::remove_floor_files(directory);
  const std::string disk = instrument::disk_facts(directory).name();
  std::vector<nlohmann::ordered_json> floors;
  for (std::size_t at = 0; at < requests.size(); ++at) {
    const bool failed = !rates[at].failure.empty();
    floors.push_back({{"disk", disk},
                      {"kind", instrument::to_string(requests[at].kind)},
                      {"direct", requests[at].direct},
                      {"own", json_of(rates[at].own)},
                      {"fio", json_of(rates[at].fio)},
                      {"agree", agreement(rates[at])},
                      {"method", rates[at].method},
                      {"failure", failed ? nlohmann::ordered_json(rates[at].failure) : nullptr}});
  }
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
