// tools/tune/findings.h: all that `plait tune` measured.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tune/measured_disk.h"
#include "tune/pick.h"
#include "tune/read_fit.h"

namespace plait::tune {

/// All that the advice rests on.
struct Findings {
  std::string input;               ///< the store or the mesh, as given
  std::string note = {};           ///< what else a reader must know, one line; may be empty
  std::string command_start = {};  ///< "plait convert surface.plait OUT"
  int finest_level = 0;
  std::uint64_t own_block_bytes = 0;
  std::optional<std::vector<std::string>> own_pipelines =
      {};  ///< [attribute] of a compressed store
  Goal goal = Goal::kRead;
  std::uint64_t seed = 0, sample_bytes = 0;
  int threads = 1;
  double seconds = 0;
  std::size_t rounds = 0;
  bool is_interrupted = false;
  MeasuredDisk disk;
  double processors = 1;
  Trials trials;

  std::vector<ReadProbe> probes = {};
  ReadFit reading = {};

  Machine machine() const { return {disk.disk, processors, reading}; }
};

}  // namespace plait::tune
