// tools/tune/advice.h: what the findings advise: a table of choices, a sentence, a command.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tune/findings.h"

namespace plait::tune {

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

}  // namespace plait::tune
