// bench/backends/round_floors.h: the floors of one round: what a plain program takes to move the
// bytes that a run needed, on the same disk and under the same memory limit.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "instrument/disk_floors.h"
#include "instrument/memory_limit.h"

namespace plait::bench {

struct RoundFloor {
  instrument::FloorResult own;
  std::optional<instrument::FloorResult> by_fio;
  /// How many times faster a second cold read was: far over 1, there is a cache below this machine.
  std::optional<double> second_cold;
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

}  // namespace plait::bench
