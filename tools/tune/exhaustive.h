// tools/tune/exhaustive.h: stores a surface with every candidate and reads it, and holds the pick
// and its prediction against the best of all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/store.h"
#include "tune/advice.h"

namespace plait::tune {

struct ExhaustiveOptions {
  std::filesystem::path directory;  ///< on the measured disk; a directory in it is made and removed
  int reads = 2;                    ///< of each candidate
  int finalists = 4;                ///< beside the pick
  int rounds = 7;                   ///< in which the pick and the finalists are read in turn
  /// Called often with the part that is done, 0 to 1. False cancels.
  std::function<bool(double done)> proceed;
};

/// A choice of the last rounds.
struct Finalist {
  Choice choice;
  double seconds = 0;    ///< the median of the rounds
  double predicted = 0;  ///< by the model, with its probes
};

struct Exhaustive {
  std::size_t stores = 0;  ///< that were made and read
  double seconds = 0;      ///< that it took
  bool is_cold = true;
  std::vector<Finalist> finalists;  ///< the pick first
  std::size_t best = 0;             ///< in `finalists`

  /// How much longer the pick takes than the best: 0.03 for 3 %.
  double pick_behind_best() const;
  /// How much longer than predicted the pick takes.
  double error_of_prediction() const;
};

/// For each size of blocks, makes stores until each pipeline of each attribute was in one, and
/// reads all of their levels, cold. An attribute's reads do not depend on the pipelines of the
/// others, except that nothing is read by pread unless nothing is compressed. So the best
/// combinations follow; the best few of them and the pick are stored again and read in turn. Needs
/// free disk for some copies of the store. Errors: those of copy_store() and read_cold(); kNoSpace.
Exhaustive try_all(const Store& store, const Findings& findings, const Advice& advice,
                   const BackendRegistry& backends, const ExhaustiveOptions& options);

std::string to_text(const Findings& findings, const Exhaustive& tried);
nlohmann::ordered_json to_json(const Findings& findings, const Exhaustive& tried);

}  // namespace plait::tune
