// bench/runs/findings.h: what a set of runs shows, and what it does not: the figures of each
// cell, which cell is the fastest where their intervals allow to say so, and every reason for
// doubt.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "instrument/statistics.h"
#include "runs/read_runs.h"

namespace plait::bench {

/// Fewer rounds in common decide nothing. Exactly this number of rounds shows only differences of
/// half and more, by the noise that all comparisons of the disk have in common.
constexpr std::size_t kLeastRounds = 2;
/// Times that differ by less are equal for all uses.
constexpr double kEqualWithin = 1.05;

struct CellFigures {
  MeasuredCell cell;
  std::string key;
  /// "uring, shuffle+lz4, blocks of 256KiB": the backend, and whatever differs between cells.
  std::string name;
  std::vector<std::size_t> runs;  ///< indices of the runs that succeeded
  std::uint64_t failed = 0;
  bool is_auto = false;  ///< what `auto` would choose
  /// "warm" if one of its runs was warm: a page cache is not to be sold as a disk.
  std::string label;
  std::optional<instrument::Estimate> seconds, ratio;
  /// The index of the run with the median time (the lower one of two).
  std::size_t middle = 0;
};

/// What is known of two cells that do the same work.
enum class Answer : std::uint8_t {
  kSlower,     ///< shown to take longer
  kEqual,      ///< shown to be within 5 %
  kUndecided,  ///< more rounds would tell
};

/// A cell beside the fastest one of its contest.
struct Rival {
  std::size_t cell = 0;
  Answer answer = Answer::kUndecided;
  instrument::Estimate factor;         ///< how many times as long, in the rounds that both have
  std::optional<double> more_seconds;  ///< until it is decided, about; empty: nobody can tell
};

/// Cells that do the same work on the same disk, within the same memory.
struct Contest {
  std::vector<std::size_t> cells;  ///< fastest first; those that cannot be ranked come last
  std::size_t ranked = 0;
  std::vector<Rival> rivals;  ///< the ranked cells but the first, in their order
  /// What to take: the fastest, and those that may be as fast. Empty: no cell could be ranked.
  std::vector<std::size_t> choices;
  /// What must not be taken: at least twice the time of the fastest, or a run of it died.
  std::vector<std::size_t> never;
  /// What is open: "which of the two: 3 more minutes", or why no cell could be ranked. Empty:
  /// nothing is open.
  std::string open;

  /// One choice is left, or two of more than two cells.
  bool is_known() const { return choices.size() == 1 || (choices.size() == 2 && cells.size() > 2); }
};

struct Findings {
  std::vector<CellFigures> cells;
  std::vector<Contest> contests;
  std::string verdict;  ///< one sentence
  bool failed = false;  ///< digests differ: no figure counts
  std::vector<std::string> doubts;
  /// This number of doubts, the first ones, spoil all figures: digests that differ, and limits that
  /// did not hold, so that the page cache may have served the runs. They stand before a table, the
  /// others after it.
  std::size_t spoiling = 0;
};

/// The runs by key, in the order in which the keys first come.
std::vector<CellFigures> cells_of(const RunSet& set);

/// The cells grouped by disk, work, size and memory, ranked, and compared with the fastest of their
/// group: paired by round, on the logarithms of seconds. The three answers are corrected for how
/// many comparisons there are, and for the choice of the fastest among many. A cell of which a run
/// failed is not ranked: its outcome is in the table, and nobody should use it. Pinned by
/// tests/bench/runs/report_test.cpp.
std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells);

/// The keys of cells that need no more rounds: those shown to take three times as long as the
/// fastest after two rounds, or a fifth longer after four, and those of groups in which each other
/// cell is such a one, or known within 5 %, or another pipeline of the fastest backend: pipelines
/// are what `plait tune` compares. If all cells of a group are of one backend, their pipelines are
/// what is asked, and go on. Nothing here depends on which answer came out, so leaving early makes
/// no answer likelier.
std::set<std::string> settled_keys(const RunSet& set);

/// Finds what limits the trust in a set of runs: `doubts`, with `spoiling` and `failed`. Records
/// hold figures and proofs, and no judgement: each doubt, with its threshold, is found in
/// doubts.cpp and nowhere else.
void add_doubts(const RunSet& set, Findings& findings);

/// REQUIRES: `set` has a run.
Findings find(const RunSet& set);

/// "pread", or "compressed, fast".
std::string way_of(const MeasuredCell& cell);
/// "4 × memory", "12.6 million vertices", or "spot.ply, 4 × memory".
std::string size_of(const MeasuredCell& cell);
/// "3 of 5 survived" of a cell with failures; empty without any.
std::string survival_of(const CellFigures& figures);
/// "1.4 to 1.7 times as long" or "equal within 5 %". REQUIRES: not kUndecided.
std::string answer_text(const Rival& rival);

/// Pairs of runs whose digests have to be equal and are not, as lines. `set` may hold the runs of
/// several files.
std::vector<std::string> digest_failures(const std::vector<MeasuredRun>& runs);

}  // namespace plait::bench
