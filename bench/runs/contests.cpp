#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <tuple>

#include "runs/findings.h"

namespace plait::bench {
namespace {

using instrument::Estimate;
using instrument::Spread;

/// The label whose cells are ranked: cold ones if there are any; warm ones never.
std::string ranked_label(const std::vector<CellFigures>& cells,
                         const std::vector<std::size_t>& among) {
  std::string found = "warm";
  for (const std::size_t at : among) {
    if (!cells[at].seconds || cells[at].label == "warm") continue;
    if (found == "warm" || cells[at].label == "cold") found = cells[at].label;
  }
  return found;
}

/// Seconds by round, of the runs that succeeded; the first one of a round.
using Rounds = std::map<std::uint64_t, double>;
Rounds rounds_of(const RunSet& set, const CellFigures& figures) {
  Rounds rounds;
  for (const std::size_t at : figures.runs)
    rounds.emplace(set.runs[at].round, set.runs[at].seconds);
  return rounds;
}

/// Seconds of two cells in the rounds that both have.
struct Pairs {
  std::vector<double> first, second;
  instrument::Comparison compare(double confidence = 0.95, const Spread& common = {}) const {
    return instrument::compare_paired(first, second, confidence, common);
  }
};
Pairs pairs_of(const Rounds& first, const Rounds& second) {
  Pairs pairs;
  for (const auto& [round, seconds] : first)
    if (const auto other = second.find(round); other != second.end()) {
      pairs.first.push_back(seconds);
      pairs.second.push_back(other->second);
    }
  return pairs;
}

/// The fastest cell of a contest and a rival.
struct Duel {
  Contest* contest;
  Rival* rival;
  Pairs pairs;
  Spread common = {};  ///< of all duels on the disk

  /// The fastest is chosen among many, so that its rivals look slower than they are: as if each
  /// pair had been compared.
  double chances() const { return static_cast<double>(contest->ranked) / 2; }
};

/// Whether a pair has rounds enough for its interval. Two rounds show large differences only, and
/// only beside other comparisons, because the noise of two rounds is no normal number.
bool can_be_shown(const Estimate& factor, const Spread& common) {
  constexpr double kLarge = 1.5;
  if (factor.confidence == 0 || factor.count < kLeastRounds) return false;
  return factor.count > kLeastRounds || (common.degrees > 0 && factor.low > kLarge);
}

Answer answer_of(const Estimate& factor, const Spread& common) {
  if (!can_be_shown(factor, common)) return Answer::kUndecided;
  if (factor.low >= 1 / kEqualWithin && factor.high <= kEqualWithin) return Answer::kEqual;
  return factor.low > 1 ? Answer::kSlower : Answer::kUndecided;
}

/// Until the interval leaves 1 or shrinks into 5 %, if the noise stays as it is.
std::optional<double> more_seconds(const instrument::Comparison& found, double confidence,
                                   double common_degrees, double seconds_of_round) {
  constexpr std::size_t kMostRounds = 10'000;
  const double difference = std::abs(std::log(found.factor.value));
  const double target = std::max(difference, std::log(kEqualWithin) - difference);
  const std::size_t now = found.factor.count;
  for (std::size_t rounds = std::max(now + 1, kLeastRounds); rounds < kMostRounds;
       rounds += 1 + rounds / 10) {
    const auto n = static_cast<double>(rounds);
    if (instrument::student_factor(n - 1 + common_degrees, confidence) * found.spread /
            std::sqrt(n) <
        target)
      return static_cast<double>(rounds - now) * seconds_of_round;
  }
  return std::nullopt;
}

double seconds_of_round(const RunSet& set, const std::vector<CellFigures>& cells,
                        const Contest& contest) {
  double seconds = 0;
  for (std::size_t at = 0; at < contest.ranked; ++at) {
    const CellFigures& figures = cells[contest.cells[at]];
    const MeasuredRun& run = set.runs[figures.middle];
    seconds += run.seconds * run.repetitions.value_or(1) + run.floor_seconds.value_or(0);
  }
  return seconds;
}

/// Puts the cells that can be ranked first, the fastest before all; says why if there is nothing to
/// compare.
void rank(Contest& contest, const RunSet& set, const std::vector<CellFigures>& cells) {
  const std::string label = ranked_label(cells, contest.cells);
  const auto can_rank = [&](std::size_t at) {
    return label != "warm" && cells[at].seconds && cells[at].label == label &&
           cells[at].failed == 0;
  };
  const auto first_unranked =
      std::stable_partition(contest.cells.begin(), contest.cells.end(), can_rank);
  contest.ranked = static_cast<std::size_t>(first_unranked - contest.cells.begin());
  if (contest.ranked < 2) {
    if (label == "warm") contest.open = "no run was cold";
    return;
  }
  // In pairs with the one that has the most rounds, because what left early ran in other rounds.
  const std::span<std::size_t> ranked(contest.cells.data(), contest.ranked);
  const std::size_t longest =
      *std::ranges::max_element(ranked, {}, [&](std::size_t at) { return cells[at].runs.size(); });
  const Rounds reference = rounds_of(set, cells[longest]);
  std::map<std::size_t, double> factors;
  for (const std::size_t at : ranked) {
    const Pairs pairs = pairs_of(reference, rounds_of(set, cells[at]));
    factors[at] = pairs.first.empty() ? cells[at].seconds->value / cells[longest].seconds->value
                                      : pairs.compare().factor.value;
  }
  std::ranges::stable_sort(ranked, {}, [&](std::size_t at) { return factors[at]; });
  for (const std::size_t at : ranked.subspan(1)) contest.rivals.emplace_back().cell = at;
}

/// Whether the rival is the fastest cell with another pipeline, while other backends compete too:
/// which backend to take does not depend on it.
bool is_other_pipeline(const std::vector<CellFigures>& cells, const Contest& contest,
                       const Rival& rival) {
  const MeasuredCell& first = cells[contest.cells.front()].cell;
  const MeasuredCell& other = cells[rival.cell].cell;
  return other.backend == first.backend && other.block_bytes == first.block_bytes &&
         other.threads == first.threads && other.budget == first.budget &&
         std::ranges::any_of(contest.rivals, [&](const Rival& each) {
           return cells[each.cell].cell.backend != first.backend;
         });
}

/// Cells of one contest have this in common.
auto work_and_place_of(const MeasuredCell& cell) {
  return std::tuple(cell.disk, cell.mesh, cell.workload, cell.vertices, cell.levels, cell.memory,
                    cell.ratio, cell.durable);
}

std::vector<Contest> ranked_contests(const RunSet& set, const std::vector<CellFigures>& cells) {
  std::map<decltype(work_and_place_of({})), Contest> contests;
  for (std::size_t at = 0; at < cells.size(); ++at)
    contests[work_and_place_of(cells[at].cell)].cells.push_back(at);
  std::vector<Contest> result;
  for (auto& [group, contest] : contests) {
    rank(contest, set, cells);
    result.push_back(std::move(contest));
  }
  return result;
}

/// The result refers to `contests`. How noisy pairs are is also taken from all of a disk: with
/// three rounds a pair alone says little of its noise.
std::vector<Duel> duels_of(const RunSet& set, const std::vector<CellFigures>& cells,
                           std::vector<Contest>& contests) {
  std::vector<Duel> duels;
  std::map<std::string, std::vector<Spread>> spreads;
  const auto disk_of = [&](const Rival& rival) { return cells[rival.cell].cell.disk; };
  for (Contest& contest : contests)
    for (Rival& rival : contest.rivals) {
      Pairs pairs =
          pairs_of(rounds_of(set, cells[contest.cells.front()]), rounds_of(set, cells[rival.cell]));
      if (pairs.first.empty()) continue;
      const double spread = pairs.compare().spread;
      spreads[disk_of(rival)].push_back(
          {spread * spread, static_cast<double>(pairs.first.size()) - 1});
      duels.push_back({&contest, &rival, std::move(pairs)});
    }
  std::map<std::string, Spread> common;
  for (const auto& [disk, of_disk] : spreads) common[disk] = instrument::common_spread(of_disk);
  for (Duel& duel : duels) duel.common = common[disk_of(*duel.rival)];
  return duels;
}

/// How long it takes to find out which of the choices is the fastest.
std::string time_to_decide(const Contest& contest) {
  double seconds = 0;
  bool known = true;
  for (const Rival& rival : contest.rivals) {
    if (rival.answer != Answer::kUndecided) continue;
    known = known && rival.more_seconds;
    seconds = std::max(seconds, rival.more_seconds.value_or(0));
  }
  if (!known || seconds > 86400) return "more rounds hardly tell";
  return seconds < 60 ? fmt::format("{:.0f} more seconds", std::ceil(seconds))
                      : fmt::format("{:.0f} more minutes", std::ceil(seconds / 60));
}

/// Fills `choices`, `never` and `open`.
void choose(Contest& contest, const std::vector<CellFigures>& cells) {
  constexpr double kNever = 2;  // times as long
  const bool others_died =
      std::ranges::all_of(std::span(contest.cells).subspan(contest.ranked),
                          [&](std::size_t at) { return cells[at].failed > 0; });
  if (contest.ranked > 1 || (contest.ranked == 1 && others_died && contest.cells.size() > 1))
    contest.choices.push_back(contest.cells.front());
  else if (contest.open.empty() && contest.cells.size() > 1)
    contest.open = contest.ranked == 0 ? "no run succeeded" : "no other run was cold";
  for (const Rival& rival : contest.rivals) {
    if (rival.answer == Answer::kUndecided) contest.choices.push_back(rival.cell);
    if (rival.answer == Answer::kSlower && rival.factor.low >= kNever)
      contest.never.push_back(rival.cell);
  }
  for (const std::size_t at : contest.cells)
    if (cells[at].failed > 0) contest.never.push_back(at);
  if (contest.choices.size() > 1)
    contest.open =
        fmt::format("which of the {}: {}",
                    contest.choices.size() == 2 ? std::string("two")
                                                : fmt::format("{}", contest.choices.size()),
                    time_to_decide(contest));
}

}  // namespace

std::string answer_text(const Rival& rival) {
  if (rival.answer == Answer::kEqual) return "equal within 5 %";
  return rival.factor.high < 1.995
             ? fmt::format("{:.2f} to {:.2f} times as long", rival.factor.low, rival.factor.high)
             : fmt::format("{:.2g} to {:.2g} times as long", rival.factor.low, rival.factor.high);
}

std::vector<Contest> contests_of(const RunSet& set, const std::vector<CellFigures>& cells) {
  std::vector<Contest> contests = ranked_contests(set, cells);
  const std::vector<Duel> duels = duels_of(set, cells, contests);
  std::vector<double> p_values;
  p_values.reserve(duels.size());
  for (const Duel& duel : duels)
    p_values.push_back(
        std::min(1.0, duel.chances() * duel.pairs.compare(0.95, duel.common).p_value));
  constexpr double kWrong = 0.05;
  const double error = 1 - instrument::confidence_among(p_values, kWrong);
  for (const Duel& duel : duels) {
    const double confidence = 1 - error / duel.chances();
    const instrument::Comparison found = duel.pairs.compare(confidence, duel.common);
    duel.rival->factor = found.factor;
    duel.rival->answer = answer_of(found.factor, duel.common);
    if (duel.rival->answer == Answer::kUndecided)
      duel.rival->more_seconds = more_seconds(found, confidence, duel.common.degrees,
                                              seconds_of_round(set, cells, *duel.contest));
  }
  for (Contest& contest : contests) choose(contest, cells);
  return contests;
}

std::set<std::string> settled_keys(const RunSet& set) {
  const std::vector<CellFigures> cells = cells_of(set);
  std::vector<Contest> contests = ranked_contests(set, cells);
  // More rounds teach nothing of use where one takes a fifth longer, or is known within 5 %. The
  // time of what takes three times as long is better given to what is near at once.
  constexpr std::size_t kRoundsToLeave = 4;
  constexpr double kFifth = 1.2, kThrice = 3;
  std::set<std::size_t> outpaced, settled;
  for (const Duel& duel : duels_of(set, cells, contests)) {
    const Estimate factor = duel.pairs.compare(1 - 0.05 / duel.chances(), duel.common).factor;
    const bool is_late = factor.count >= kRoundsToLeave;
    if (can_be_shown(factor, duel.common) && factor.low > (is_late ? kFifth : kThrice)) {
      outpaced.insert(duel.rival->cell);
      settled.insert(duel.rival->cell);
    }
    if (is_late && factor.high / factor.low < kEqualWithin * kEqualWithin)
      settled.insert(duel.rival->cell);
  }
  std::set<std::string> keys;
  for (const Contest& contest : contests) {
    const bool all = std::ranges::all_of(contest.rivals, [&](const Rival& rival) {
      return settled.contains(rival.cell) || is_other_pipeline(cells, contest, rival);
    });
    for (const std::size_t at : contest.cells) {
      // Alone, a cell has five rounds to say how long it takes; one that fails is not to be used.
      const std::size_t rounds = cells[at].runs.size() + cells[at].failed;
      if (contest.ranked < 2 ? rounds >= 5 : all || outpaced.contains(at) || cells[at].failed >= 2)
        keys.insert(cells[at].key);
    }
  }
  return keys;
}

}  // namespace plait::bench
