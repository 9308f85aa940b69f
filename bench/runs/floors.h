// bench/runs/floors.h: what a plain program takes to move the bytes that a run needed, on the
// same disk, in the same round and under the same memory limit; and what disks can do at all, for
// `plait bench floors`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "instrument/disk_floors.h"
#include "instrument/memory_limit.h"

namespace plait::bench {

struct RoundFloor {
  instrument::FloorResult own;
  std::optional<instrument::FloorResult> by_fio = {};
  /// How many times faster a second cold read was: far over 1, there is a cache below this machine.
  std::optional<double> second_cold = {};
};

/// Measures each floor once in a round, in processes of its own. REQUIRES: one thread.
class RoundFloors {
 public:
  /// `fio`: also by fio, in the first round.
  explicit RoundFloors(bool fio) : fio_(fio) {}
  void begin_round(int round) {
    floors_.clear();
    is_first_ = round == 0;
  }
  /// `limit` is nullptr for none. Errors: as own_floor().
  const RoundFloor& floor(const instrument::FloorRequest& request,
                          const instrument::MemoryLimit* limit);

 private:
  RoundFloor measure(const instrument::FloorRequest& request,
                     const instrument::MemoryLimit* limit) const;

  bool fio_, is_first_ = true;
  std::map<std::string, RoundFloor> floors_;
};

/// Measures each kind of floor, buffered and direct, by our own program and, where it has the same
/// pattern, by fio: five rounds. Returns an object a floor: {disk, kind, direct, own, fio, agree,
/// method, failure}; own and fio are {bytes_per_second, low, high, least, most, rounds} or null.
/// `before_each` is called before each measurement, and may throw. Needs `bytes` twice on the disk.
/// Errors: kIo, kNoSpace for the directory. REQUIRES: one thread.
std::vector<nlohmann::ordered_json> measure_floors(const std::filesystem::path& directory,
                                                   std::uint64_t bytes, std::uint64_t block_bytes,
                                                   bool fio,
                                                   const std::function<void()>& before_each);
/// Columns for a terminal.
std::string floor_table(const std::vector<nlohmann::ordered_json>& floors);

}  // namespace plait::bench
