// tools/tune/report.h: what `plait tune` found, as text and as JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tune/advice.h"
#include "tune/measured_disk.h"

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

  Machine machine() const { return {disk.disk, processors}; }
};

/// A row of the table of choices.
struct ChoiceRow {
  Choice choice;
  std::string names = {};  ///< "pick", "preset small", "as it is", joined by commas; may be empty
  bool on_front = false, is_pick = false;
  bool is_like_pick = false;             ///< no_difference() from the pick
  std::optional<double> next_from = {};  ///< as FrontMember
  double stored_bytes = 0, ratio = 0;
  Predicted seconds = {}, low = {}, high = {};  ///< on this disk
};

/// The advice, decided from the findings.
struct Advice {
  Choice pick;
  std::vector<ChoiceRow> rows;  ///< the smallest first
  std::vector<SpeedRange> ranges;
  std::string sentence, command;
};

/// Errors: kInvalidArgument if no pipeline was measured for each attribute.
Advice advise(const Findings& findings);

/// The command that stores the surface as chosen: `start` with --backend, --block and --compress.
std::string command_for(const Trials& trials, const Choice& choice, const std::string& start);
/// The pipelines of a choice, as the values of --compress: "position=shuffle,lz4".
std::vector<std::string> compress_arguments(const Trials& trials, const Choice& choice);

std::string to_text(const Findings& findings, const Advice& advice);
nlohmann::ordered_json to_json(const Findings& findings, const Advice& advice);

}  // namespace plait::tune
