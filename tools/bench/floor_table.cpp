#include "bench/floor_table.h"

#include <fmt/format.h>

#include <string_view>

#include "instrument/disk.h"
#include "instrument/disk_floors.h"
#include "instrument/process.h"
#include "plait/error.h"

namespace plait::bench {

using instrument::FloorKind;
using instrument::FloorRequest;

std::vector<nlohmann::ordered_json> measure_floors(const std::filesystem::path& directory,
                                                   std::uint64_t bytes, std::uint64_t block_bytes,
                                                   bool fio) {
  std::vector<nlohmann::ordered_json> floors;
  const std::string disk = instrument::disk_facts(directory).name();
  for (const FloorKind kind :
       {FloorKind::kWrite, FloorKind::kRead, FloorKind::kRandomRead, FloorKind::kUpdate})
    for (const bool direct : {false, true}) {
      const FloorRequest request{.directory = directory,
                                 .kind = kind,
                                 .bytes = bytes,
                                 .block_bytes = block_bytes,
                                 .direct = direct};
      nlohmann::ordered_json floor = {{"directory", directory.native()},
                                      {"disk", disk},
                                      {"kind", instrument::to_string(kind)},
                                      {"direct", direct},
                                      {"own", nullptr},
                                      {"fio", nullptr},
                                      {"agree", nullptr},
                                      {"failure", nullptr}};
      try {
        const nlohmann::json both = instrument::in_own_process([&]() -> nlohmann::json {
          const instrument::FloorResult own = own_floor(request);
          nlohmann::json results = {{"own", to_json(own)}, {"fio", nullptr}, {"agree", nullptr}};
          if (const auto other = fio ? fio_floor(request) : std::nullopt) {
            results["fio"] = to_json(*other);
            results["agree"] =
                instrument::agree(1 / own.bytes_per_second(), 1 / other->bytes_per_second());
          }
          return results;
        });
        floor.update(both);
      } catch (const Error& error) {
        floor["failure"] = error.what();
      }
      floors.push_back(floor);
    }
  instrument::remove_floor_files(directory);
  return floors;
}

std::string floor_table(const std::vector<nlohmann::ordered_json>& floors) {
  const auto rate = [](const nlohmann::ordered_json& floor) {
    return floor.is_object() ? fmt::format("{:.0f}", 1e-6 *
                                                         (floor["bytes_read"].get<double>() +
                                                          floor["bytes_written"].get<double>()) /
                                                         floor["seconds"].get<double>())
                             : std::string("-");
  };
  std::string text =
      "| disk | floor | MB/s | fio MB/s | how | doubt |\n|---|---|---|---|---|---|\n";
  for (const nlohmann::ordered_json& floor : floors) {
    const nlohmann::ordered_json& own = floor["own"];
    const std::string doubt = floor["failure"].is_string() ? floor["failure"].get<std::string>()
                              : floor["agree"] == false    ? "fio differs by more than a tenth"
                                                           : "";
    text += fmt::format("| {} | {}{} | {} | {} | {} | {} |\n", floor["disk"].get<std::string>(),
                        floor["kind"].get<std::string>(), floor["direct"] == true ? ", direct" : "",
                        rate(own), rate(floor["fio"]),
                        own.is_object() ? own["method"].get<std::string>() : "-", doubt);
  }
  return text;
}

}  // namespace plait::bench
