// bench/tune/rounds.h: measures choices in turn, and decides between them from what was measured.
// It stores nothing itself, so tests give it a made-up disk: tests/bench/tune/rounds_test.cpp.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "instrument/statistics.h"
#include "tune/copy.h"

namespace plait::tune {

/// What shall be small.
enum class Goal : std::uint8_t { kRead, kWrite, kUpdate, kSize, kBalanced };
std::string_view to_string(Goal goal) noexcept;
/// Errors: kInvalidArgument; the message lists the goals.
Goal goal_from_name(std::string_view name);
/// The seconds of a full read or of a full write; of both, for changing all records; the stored
/// bytes; or, balanced, the cube root of their product, so that a tenth of each counts the same.
double cost(Goal goal, const CopyFigures& figures);

/// Times that differ by less than this factor are equal for all uses.
inline constexpr double kEqualWithin = 1.03;
/// The same of bytes, which are not measured but counted.
inline constexpr double kEqualBytes = 1.01;
/// This number of rounds tells whether anything is open, and there are at most as many.
inline constexpr std::size_t kEnoughRounds = 4, kMostRounds = 16;

/// A choice with what it took in each round until it left.
struct Measured {
  Choice choice;
  std::vector<CopyRun> runs = {};  ///< [round]
  bool left = false;               ///< shown to be a fifth slower than the best
  std::string refused = {};        ///< why it cannot be stored so; then there are no runs

  /// REQUIRES: there is a run.
  double stored_bytes() const { return runs.back().stored_bytes; }
};
/// Of all runs.
instrument::Estimate estimate(const Measured& measured, double CopyFigures::*seconds);

/// Measures a choice once.
using Run = std::function<CopyRun(const Choice& choice)>;

/// Adds rounds to `choices`, each with one run of every choice, in rotating order, while another
/// one as long as the last ends before `clock` shows `seconds`, and something is open; but one
/// round in any case. A choice that refuses the records (kNotSupported, kInvalidArgument) says why
/// and gets no more runs. Returns false if kCancelled ended it early; incomplete rounds are then
/// dropped, unless there is no complete one.
bool measure_rounds(std::vector<Measured>& choices, Goal goal, double seconds,
                    const std::function<double()>& clock, const Run& run);

/// How a choice compares with the pick, by the rounds that both have.
struct Beside {
  instrument::Comparison cost;  ///< over 1: the goal costs more than with the pick
  bool is_tied = false;         ///< not shown to be different, or by less than kEqualWithin
};

struct Decision {
  std::size_t pick = 0;
  std::vector<std::optional<Beside>> beside;  ///< [choice] nothing for the pick and what has no run
};

/// The choice of least cost. Of those that tie with it, presets go first, then the fewest bytes, if
/// they differ by more than a hundredth, then the first. Errors: kCancelled if nothing was
/// measured; kNotSupported if no choice can do what the goal asks for.
Decision decide(const std::vector<Measured>& choices, Goal goal);

}  // namespace plait::tune
