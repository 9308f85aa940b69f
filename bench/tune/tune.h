// bench/tune/tune.h: what `plait tune` measures: up to six ways to store a surface, each stored in
// full on a disk and read, in rounds.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "instrument/surroundings.h"
#include "tune/rounds.h"
#include "tune/sample.h"

namespace plait::tune {

struct TuneOptions {
  std::filesystem::path directory;  ///< on the disk
  double seconds = 60;              ///< no round begins that would end later
  Goal goal = Goal::kRead;
  /// Called often, with the part that is done, 0 to 1. False ends the measurement; what there is by
  /// then is reported.
  std::function<bool(std::string_view phase, double done)> proceed;
};

/// All that was measured.
struct TuneFindings {
  std::string input;               ///< the store or the mesh, as given
  std::string command_start = {};  ///< "plait convert surface.plait OUT"
  std::filesystem::path directory;
  Goal goal = Goal::kRead;
  double seconds = 0;
  double seconds_for_enough = 0;  ///< what four rounds would take, if there were fewer; else 0
  int finest_level = 0;
  std::uint64_t raw_bytes = 0, block_bytes = 0;
  bool is_interrupted = false;
  Sample sample;
  std::vector<Measured> choices;
  instrument::Surroundings surroundings;  ///< while the rounds were measured
  std::vector<std::string> notes = {};    ///< what else a reader must know, in lines
};

/// The most choices that are stored in full.
inline constexpr std::size_t kMostChoices = 6;

/// Measures `none` and the presets; each preset that stores normals also with normals that are made
/// again, if most of their blocks are equal bit by bit; and what propose() adds, up to
/// kMostChoices. The first runs of the presets only inform the proposals, unless `seconds` have no
/// room for a round: then they are all that there is. The store is only read.
/// Errors: kInvalidArgument for a store without levels; kNoSpace if the disk has no room for a
/// copy; kCancelled if `proceed` returned false before a choice was measured; those of reading.
TuneFindings measure_store(Store& store, const PipelineRegistry& registry,
                           const TuneOptions& options);

}  // namespace plait::tune
