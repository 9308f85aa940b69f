// bench/runs/comparison.h: compares two sets of runs, cell by cell and in strata.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "runs/findings.h"

namespace plait::bench {

/// Two sets beside each other: in a cell that both measured, or over a stratum of such cells.
struct Shift {
  std::string name;    ///< of a cell: work, size, disk and backend; "backend uring"; "all cells"
  std::string figure;  ///< of a cell: "ratio" to the floor of each run's round, or "seconds"
  std::size_t before = 0, after = 0;  ///< runs
  std::size_t cells = 1;
  /// By which factor the second set is slower (over 1) or faster. The interval is corrected for how
  /// many shifts are looked at.
  instrument::Estimate factor;
  double p_value = 1, adjusted = 1;  ///< `adjusted` for how many there are (Benjamini and Hochberg)
  bool differs = false;              ///< adjusted is at most 5 %
  bool regression = false;           ///< and the factor is over 1 + threshold
};

struct SetComparison {
  std::vector<Shift> cells;
  /// Those of at least three cells: all, each backend with its pipeline, each workload, each disk.
  /// A shift that no single cell can show is seen here.
  std::vector<Shift> strata;
  bool regression = false;
  bool failed = false;  ///< digests differ, or a cell that worked before fails now
  std::string verdict;
  std::vector<std::string> doubts;
  double threshold = 0;

  bool passes() const { return !failed && !regression; }
};

/// Compares `after` with `before`. Where both sets have ratios to floors, those are compared, so
/// that a disk that was slow as a whole is no regression. Errors: kInvalidArgument if no cell is in
/// both. Pinned by tests/bench/runs/report_test.cpp.
SetComparison compare(const RunSet& before, const RunSet& after, double threshold);

nlohmann::ordered_json to_json(const SetComparison& comparison);
std::string to_text(const SetComparison& comparison);

}  // namespace plait::bench
