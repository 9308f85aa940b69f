// bench/findings.h: what a set of runs shows, and what it does not: the figures of each cell, which
// cell is the fastest where their intervals allow to say so, and every reason for doubt.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/read_runs.h"
#include "instrument/statistics.h"

namespace plait::bench {

/// Fewer rounds than this decide nothing.
constexpr std::size_t kLeastRounds = 5;

struct CellFigures {
  MeasuredCell cell;
  /// "uring, shuffle+lz4, blocks of 256KiB": the backend, and whatever differs between cells.
  std::string name;
  std::vector<std::size_t> runs;  ///< indices of the runs that succeeded
  std::uint64_t failed = 0;
  /// "warm" if one of its runs was warm: a page cache is not to be sold as a disk.
  std::string label;
  std::optional<instrument::Estimate> seconds, ratio;
  /// The index of the run with the median time (the lower one of two).
  std::size_t middle = 0;
};

/// Cells that do the same work on the same disk, within the same memory.
struct Contest {
  std::vector<std::size_t> cells;  ///< fastest first; those that cannot be ranked come last
  std::size_t ranked = 0;
  bool decided = false;  ///< the first one's interval of times overlaps with no other's
  std::string why_not;   ///< if not decided
  double lead = 0;       ///< median time of the second over that of the first, if two are ranked
};

struct Findings {
  std::vector<CellFigures> cells;
  std::vector<Contest> contests;
  std::string verdict;  ///< one sentence
  bool failed = false;  ///< digests differ: no figure counts
  bool doubtful = false;
  std::vector<std::string> doubts;
  /// The first so many doubts spoil all figures: digests that differ, and limits that did not hold.
  std::size_t spoiling = 0;
};

/// REQUIRES: `set` has a run.
Findings find(const RunSet& set);

/// "4 × memory", "12.6 million vertices", or "spot.ply, 4 × memory".
std::string size_of(const MeasuredCell& cell);
/// "sweep-read" with its rate and durability.
std::string work_of(const MeasuredCell& cell);

/// Findings as JSON: {verdict, failed, doubts, cells, comparisons, runs, skipped}.
nlohmann::ordered_json to_json(const RunSet& set, const Findings& findings);

/// What a terminal shows: the doubts that spoil everything, a table with the ratio to the floor
/// first, the verdict, and the other doubts.
std::string to_text(const RunSet& set, const Findings& findings);

/// Pairs of runs whose digests have to be equal and are not, as lines. `set` may hold the runs of
/// several files.
std::vector<std::string> digest_failures(const std::vector<MeasuredRun>& runs);

}  // namespace plait::bench
