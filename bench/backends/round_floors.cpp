#include "backends/round_floors.h"

#include <fmt/format.h>

#include <algorithm>

#include "instrument/process.h"

namespace plait::bench {
namespace {

namespace fs = std::filesystem;
using instrument::FloorKind;
using instrument::FloorRequest;
using instrument::FloorResult;

nlohmann::json to_child_json(const FloorResult& floor) { return instrument::to_json(floor); }
FloorResult from_child_json(const nlohmann::json& json) {
  return {json["seconds"].get<double>(), json["bytes_read"].get<std::uint64_t>(),
          json["bytes_written"].get<std::uint64_t>(), json["method"].get<std::string>(),
          json["cold"].get<bool>()};
}

}  // namespace

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
  const auto once = [&] {
    return from_child_json(
        instrument::run_in_own_process([&] { return to_child_json(own_floor(request)); }, limit)
            .result);
  };
  RoundFloor floor{once(), {}, {}};
  if (!is_first_) return floor;
  if (request.kind == FloorKind::kRead) floor.second_cold = floor.own.seconds / once().seconds;
  if (fio_ && instrument::have_fio()) {
    const nlohmann::json by_fio =
        instrument::run_in_own_process(
            [&]() -> nlohmann::json {
              const auto result = fio_floor(request);
              return result ? to_child_json(*result) : nlohmann::json(nullptr);
            },
            limit)
            .result;
    if (by_fio.is_object()) floor.by_fio = from_child_json(by_fio);
  }
  return floor;
}

}  // namespace plait::bench
