#include "backends/round_floors.h"

#include <fmt/format.h>

#include <algorithm>

#include "instrument/process.h"

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
  RoundFloor floor{once(), {}, {}};
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

}  // namespace plait::bench
