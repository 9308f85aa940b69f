// bench/instrument/surroundings.h: what else the machine did while something was measured.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/stopwatch.h"

namespace plait::instrument {

/// Shares are of the time that all processors had.
struct Surroundings {
  double load = 0;    ///< processes that could run, as /proc/loadavg has it for the last minute
  double others = 0;  ///< of other programs, outside the kernel: its threads may have worked for us
  double stolen = 0;  ///< of other machines on the same host
  /// Shares of the time in which something waited for a processor, the disk, or memory (PSI), our
  /// own work included; empty where the kernel does not tell.
  std::map<std::string, std::optional<double>> pressure = {};  ///< of "cpu", "io", "memory"

  /// Of `others` and `stolen`: how much of the machine was not there for what was measured.
  double disturbance() const { return others + stolen; }
};
nlohmann::ordered_json to_json(const Surroundings& surroundings);

/// More than this is a reason for doubt.
constexpr double kDisturbed = 0.10;

/// Begins when it is made. For one thread.
class SurroundingsWatch {
 public:
  SurroundingsWatch();
  /// Since then. `own_seconds`: processor time outside the kernel of what is measured; that of this
  /// process itself is known.
  Surroundings since(double own_seconds) const;

 private:
  struct Counters {
    double user = 0, stolen = 0, all = 0;  ///< processor seconds of the machine
    double own = 0;                        ///< of this process, outside the kernel
    std::array<std::optional<double>, 3> waited;
  };
  static Counters now();

  Stopwatch clock_;
  Counters start_;
};

}  // namespace plait::instrument
