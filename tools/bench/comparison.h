// bench/comparison.h: compares two sets of runs, cell by cell and as a whole.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/findings.h"

namespace plait::bench {

/// A cell that both sets measured.
struct ComparedCell {
  std::string name;  ///< work, size, disk and backend
  std::string
      figure;  ///< what was compared: "ratio" to the floor of each run's round, or "seconds"
  std::size_t before = 0, after = 0;  ///< runs
  /// By which factor the second set is slower (over 1) or faster, with its 95 % interval.
  instrument::Estimate factor;
  double p_value = 1;    ///< of Mann and Whitney's test
  double adjusted = 1;   ///< the same among all cells (Benjamini and Hochberg)
  bool differs = false;  ///< adjusted is at most 5 %
  bool regression = false;
};

struct Comparison {
  std::vector<ComparedCell> cells;
  /// The factor over all cells, by Wilcoxon's test of the cells' factors. Needs two cells.
  std::optional<instrument::Estimate> factor;
  double p_value = 1;
  bool differs = false, regression = false;
  bool failed = false;  ///< digests differ, or a cell that worked before fails now
  std::string verdict;
  std::vector<std::string> doubts;
  double threshold = 0;

  bool passes() const { return !failed && !regression; }
};

/// Compares `after` with `before`. A regression is a difference that is shown (5 %) and whose
/// factor is over 1 + threshold, in a cell or over all. Where both sets have ratios to floors,
/// those are compared, so that a disk that was slow as a whole is no regression. Errors:
/// kInvalidArgument if no cell is in both.
Comparison compare(const RunSet& before, const RunSet& after, double threshold);

/// "1.100 (1.050 to 1.160)". "10 % slower (5 % slower to ..." is hard to read; factors are not.
std::string factor_text(const instrument::Estimate& factor);
nlohmann::ordered_json to_json(const Comparison& comparison);
std::string to_text(const Comparison& comparison);

}  // namespace plait::bench
