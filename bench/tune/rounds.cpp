#include "tune/rounds.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "plait/error.h"

namespace plait::tune {
namespace {

/// What is shown to take so much longer leaves, and gives its time to the rest.
constexpr double kLeavesFrom = 1.2;
constexpr double kSignificance = 0.05;

constexpr NameTable<Goal, 5> kGoals("goal", {{Goal::kRead, "read"},
                                             {Goal::kWrite, "write"},
                                             {Goal::kUpdate, "update"},
                                             {Goal::kSize, "size"},
                                             {Goal::kBalanced, "balanced"}});

bool can_compete(const Measured& measured, Goal goal) {
  return !measured.runs.empty() && (goal != Goal::kUpdate || measured.runs.back().can_change);
}

Beside beside(const Measured& pick, const Measured& other, Goal goal) {
  std::vector<double> first, second;
  for (std::size_t at = 0; at < std::min(pick.runs.size(), other.runs.size()); ++at) {
    first.push_back(cost(goal, pick.runs[at]));
    second.push_back(cost(goal, other.runs[at]));
  }
  Beside found{instrument::compare_paired(first, second), false};
  const double factor = found.cost.factor.value;
  const double equal = goal == Goal::kSize ? kEqualBytes : kEqualWithin;
  // A wide interval is no licence: with 10 % more, nobody calls it a tie.
  found.is_tied =
      factor <= equal || (found.cost.p_value > kSignificance && factor <= equal * equal * equal);
  return found;
}

std::size_t cheapest(const std::vector<Measured>& choices, Goal goal) {
  std::optional<std::size_t> best;
  for (std::size_t at = 0; at < choices.size(); ++at)
    if (can_compete(choices[at], goal) &&
        (!best || beside(choices[*best], choices[at], goal).cost.factor.value < 1))
      best = at;
  if (best) return *best;
  if (std::ranges::any_of(choices, [](const Measured& one) { return !one.runs.empty(); }))
    throw Error(ErrorCode::kNotSupported,
                "tune: every choice codes blocks from other blocks, so no record can be changed in "
                "place; choose another goal");
  throw Error(ErrorCode::kCancelled, "tune: cancelled before anything was measured");
}

/// Lets go what need not be measured any more. False: nothing is open.
bool is_open(std::vector<Measured>& choices, Goal goal) {
  const std::size_t best = cheapest(choices, goal);
  bool open = false;
  for (std::size_t at = 0; at < choices.size(); ++at) {
    if (at == best || choices[at].left || !can_compete(choices[at], goal)) continue;
    const instrument::Estimate factor = beside(choices[best], choices[at], goal).cost.factor;
    choices[at].left = factor.low > kLeavesFrom;
    const bool is_known = factor.low > kEqualWithin || factor.high < kEqualWithin;
    open = open || (!choices[at].left && !is_known);
  }
  return open;
}

}  // namespace

std::string_view to_string(Goal goal) noexcept { return kGoals.name_of(goal); }
Goal goal_from_name(std::string_view name) { return kGoals.find(name); }

double cost(Goal goal, const CopyFigures& figures) {
  switch (goal) {
    case Goal::kRead:
      return figures.read_seconds;
    case Goal::kWrite:
      return figures.write_seconds;
    case Goal::kUpdate:
      return figures.read_seconds + figures.write_seconds;
    case Goal::kSize:
      return figures.stored_bytes;
    case Goal::kBalanced:
      break;
  }
  return std::cbrt(figures.read_seconds * figures.write_seconds * figures.stored_bytes);
}

instrument::Estimate estimate(const Measured& measured, double CopyFigures::*seconds) {
  std::vector<double> values;
  for (const CopyRun& run : measured.runs) values.push_back(run.*seconds);
  return instrument::geometric_interval(values);
}

bool measure_rounds(std::vector<Measured>& choices, Goal goal, double seconds,
                    const std::function<double()>& clock, const Run& run) {
  for (std::size_t round = 0; round < kMostRounds; ++round) {
    const double before = clock();
    try {
      for (std::size_t i = 0; i < choices.size(); ++i) {
        Measured& one = choices[(round + i) % choices.size()];
        if (one.left || !one.refused.empty()) continue;
        try {
          one.runs.push_back(run(one.choice));
        } catch (const Error& error) {
          if (!is_refusal(error)) throw;
          one.refused = error.what();
        }
      }
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCancelled) throw;
      for (Measured& one : choices)
        if (round > 0 && one.runs.size() > round) one.runs.pop_back();
      return false;
    }
    if (round + 1 >= kEnoughRounds && !is_open(choices, goal)) break;
    // The next round takes as long as this one.
    if (const double now = clock(); now + (now - before) > seconds) break;
  }
  return true;
}

Decision decide(const std::vector<Measured>& choices, Goal goal) {
  Decision decision;
  const std::size_t best = cheapest(choices, goal);
  decision.pick = best;
  for (std::size_t at = 0; at < choices.size(); ++at) {
    if (at == best || !can_compete(choices[at], goal)) continue;
    if (!beside(choices[best], choices[at], goal).is_tied) continue;
    const Measured &pick = choices[decision.pick], &other = choices[at];
    const bool is_smaller = other.stored_bytes() * kEqualBytes < pick.stored_bytes();
    const bool is_larger = pick.stored_bytes() * kEqualBytes < other.stored_bytes();
    const bool goes_first = other.choice.is_preset != pick.choice.is_preset
                                ? other.choice.is_preset
                                : is_smaller || (!is_larger && at < decision.pick);
    if (goes_first) decision.pick = at;
  }
  for (std::size_t at = 0; at < choices.size(); ++at)
    if (at == decision.pick || choices[at].runs.empty())
      decision.beside.emplace_back();
    else
      decision.beside.emplace_back(beside(choices[decision.pick], choices[at], goal));
  return decision;
}

}  // namespace plait::tune
