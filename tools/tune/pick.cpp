#include "tune/pick.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "plait/error.h"
#include "tune/front.h"

namespace plait::tune {
namespace {

constexpr std::array<std::pair<Goal, std::string_view>, 5> kNames = {
    {{Goal::kRead, "read"},
     {Goal::kWrite, "write"},
     {Goal::kUpdate, "update"},
     {Goal::kSize, "size"},
     {Goal::kBalanced, "balanced"}}};
/// Times are not more exact, and no user notices less.
constexpr double kLeastDifference = 0.01;
/// How exact the medians of a few reads are.
constexpr double kReadDifference = 0.03;
/// A single part says nothing of the spread: then only a clear difference counts.
constexpr double kUnknownSpread = 0.25;

double sum(const std::vector<Work>& works, double Work::*member) {
  double sum = 0;
  for (const Work& work : works) sum += work.*member;
  return sum;
}

std::string_view words_for(Goal goal) {
  switch (goal) {
    case Goal::kRead:
      return "For a full read";
    case Goal::kWrite:
      return "For a full write";
    case Goal::kUpdate:
      return "For changing records in place";
    case Goal::kSize:
      return "For size";
    case Goal::kBalanced:
      break;
  }
  return "For reading, writing and size together";
}

/// Two digits: the speed of no disk is known better.
std::string speed_text(double bytes_per_second) {
  const double unit = std::pow(10, std::floor(std::log10(bytes_per_second)) - 1);
  const double rounded = std::round(bytes_per_second / unit) * unit;
  return rounded < 0.9999e9 ? fmt::format("{:.4g} MB/s", rounded / 1e6)
                            : fmt::format("{:.4g} GB/s", rounded / 1e9);
}

}  // namespace

std::string_view to_string(Goal goal) noexcept {
  return std::ranges::find(kNames, goal, [](const auto& each) { return each.first; })->second;
}

const std::vector<Goal>& all_goals() {
  static const std::vector<Goal> goals = {Goal::kRead, Goal::kWrite, Goal::kUpdate, Goal::kSize,
                                          Goal::kBalanced};
  return goals;
}

Goal goal_from_name(std::string_view name) {
  for (const auto& [goal, goal_name] : kNames)
    if (name == goal_name) return goal;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose a goal: expected read, write, update, size or balanced, found "
                          "\"{}\"",
                          name));
}

Machine with_speed(Machine machine, double bytes_per_second) {
  machine.disk.read = machine.disk.write = machine.disk.random_read = bytes_per_second;
  machine.disk.of_blocks.clear();
  machine.disk.burst_bytes = 0;
  machine.disk.is_measured = false;
  return machine;
}

double cost(Goal goal, const std::vector<Work>& works, const Machine& machine) {
  const Predicted seconds = predict(works, machine);
  const double stored = sum(works, &Work::stored_bytes);
  switch (goal) {
    case Goal::kRead:
      return seconds.read;
    case Goal::kWrite:
      return seconds.write;
    case Goal::kUpdate:
      return seconds.update.value_or(std::numeric_limits<double>::infinity());
    case Goal::kSize:
      return stored;
    case Goal::kBalanced:
      break;
  }
  return std::cbrt(seconds.read * seconds.write * stored);
}

double processor_cost(Goal goal, const std::vector<Work>& works) {
  double seconds = 0;
  if (goal != Goal::kWrite) seconds += sum(works, &Work::decode_seconds);
  if (goal != Goal::kRead && goal != Goal::kSize) seconds += sum(works, &Work::encode_seconds);
  return seconds;
}

Figure compare(const Trials& trials, Goal goal, const Choice& a, const Choice& b,
               const Machine& machine) {
  const auto logarithm = [&](std::optional<LeftOut> without) {
    return std::log(cost(goal, work_of(trials, a, Bound::kValue, without), machine) /
                    cost(goal, work_of(trials, b, Bound::kValue, without), machine));
  };
  const double value = logarithm({});
  if (!std::isfinite(value)) return {value, value, value};
  if (goal == Goal::kRead && machine.disk.is_measured && was_probed(trials, a) &&
      was_probed(trials, b))
    return {value, value - kReadDifference, value + kReadDifference};
  double variance = 0;
  for (std::size_t id = 0; id < trials.attributes.size(); ++id) {
    const std::size_t parts = common_parts(trials, id).size();
    if (trials.attributes[id].is_whole && parts == trials.attributes[id].parts) continue;
    if (parts < 2) return {value, value - kUnknownSpread, value + kUnknownSpread};
    std::vector<double> left_out;
    double mean = 0;
    for (std::size_t part = 0; part < parts; ++part) {
      left_out.push_back(logarithm(LeftOut{id, part}));
      mean += left_out.back() / static_cast<double>(parts);
    }
    double squares = 0;
    for (const double each : left_out) squares += (each - mean) * (each - mean);
    variance += squares * static_cast<double>(parts - 1) / static_cast<double>(parts);
  }
  const double error = std::max(kLeastDifference, 2 * std::sqrt(variance));
  return {value, value - error, value + error};
}

bool no_difference(const Trials& trials, Goal goal, const Choice& a, const Choice& b,
                   const Machine& machine) {
  if (a == b) return true;
  const Figure ratio = compare(trials, goal, a, b, machine);
  return ratio.low <= 0 && ratio.high >= 0;
}

Choice pick(const Trials& trials, Goal goal, const Machine& machine) {
  std::vector<Choice> choices = worthwhile_choices(trials);
  for (const std::uint64_t block_bytes : block_sizes(trials))
    if (const auto none = preset_choice(trials, block_bytes, "none")) choices.push_back(*none);
  if (choices.empty())
    throw Error(ErrorCode::kInvalidArgument, "tune: no pipeline was measured for each attribute");
  const auto least = [&](const std::vector<Choice>& among) {
    return *std::ranges::min_element(among, {}, [&](const Choice& choice) {
      return cost(goal, work_of(trials, choice), machine);
    });
  };
  Choice best = least(choices);
  for (const std::uint64_t block_bytes : block_sizes(trials)) {
    const auto none = preset_choice(trials, block_bytes, "none");
    if (none && no_difference(trials, goal, *none, best, machine)) {
      // Blocks as they are take the same bytes in any size: the store keeps its own.
      const auto own = preset_choice(trials, best.block_bytes, "none");
      return own && no_difference(trials, goal, *own, *none, machine) ? *own : *none;
    }
  }
  return best;
}

std::vector<FrontMember> front_of(const Trials& trials, Goal goal, std::uint64_t block_bytes,
                                  const Machine& machine) {
  std::vector<Choice> choices;
  for (const Choice& choice : worthwhile_choices(trials))
    if (choice.block_bytes == block_bytes &&
        std::isfinite(cost(goal, work_of(trials, choice), machine)))
      choices.push_back(choice);
  std::vector<Costs> costs;
  for (const Choice& choice : choices) {
    const std::vector<Work> works = work_of(trials, choice);
    costs.push_back({sum(works, &Work::stored_bytes), processor_cost(goal, works)});
  }
  std::vector<FrontMember> front;
  for (const std::size_t at : pareto_front(costs)) front.push_back({choices[at], {}});
  for (std::size_t i = 0; i + 1 < front.size(); ++i) {
    const auto seconds = [&](const Choice& choice) -> SecondsAtSpeed {
      return [works = work_of(trials, choice), goal, machine](double speed) {
        return cost(goal, works, with_speed(machine, speed));
      };
    };
    front[i].next_from = break_even(seconds(front[i].choice), seconds(front[i + 1].choice));
  }
  return front;
}

namespace {

struct Member {
  Choice choice;
  std::vector<Work> works;
};

/// The ranges of speeds, the next of which is better by the part `gain` where it begins.
template <class CostAt>
std::vector<SpeedRange> ranges_of(const std::vector<Member>& members, CostAt cost_at, double gain) {
  constexpr double kStep = 1.05;
  std::vector<SpeedRange> ranges;
  const Member* current = nullptr;
  for (double speed = kSlowestDisk; speed < kFastestDisk && !members.empty(); speed *= kStep) {
    const Member& best = *std::ranges::min_element(
        members, {}, [&](const Member& member) { return cost_at(member, speed); });
    if (current != nullptr && cost_at(best, speed) >= (1 - gain) * cost_at(*current, speed))
      continue;
    const auto from = current == nullptr
                          ? std::optional(0.0)
                          : break_even([&](double at) { return cost_at(*current, at); },
                                       [&](double at) { return cost_at(best, at); });
    if (!ranges.empty()) ranges.back().fastest = from.value_or(speed);
    ranges.push_back({best.choice, from.value_or(speed), std::numeric_limits<double>::infinity()});
    current = &best;
  }
  return ranges;
}

}  // namespace

std::vector<SpeedRange> best_at_speeds(const Trials& trials, Goal goal, std::uint64_t block_bytes,
                                       const Machine& machine) {
  std::vector<Member> members;
  for (const FrontMember& member : front_of(trials, goal, block_bytes, machine))
    members.push_back({member.choice, work_of(trials, member.choice)});
  const auto cost_at = [&](const Member& member, double speed) {
    return cost(goal, member.works, with_speed(machine, speed));
  };
  // A sentence that names more choices helps nobody, so smaller gains are left out of it.
  constexpr std::size_t kMostRanges = 3;
  std::vector<SpeedRange> ranges;
  for (const double gain : {0.02, 0.05, 0.1, 0.2, 0.3, 0.5}) {
    ranges = ranges_of(members, cost_at, gain);
    if (ranges.size() <= kMostRanges) break;
  }
  return ranges;
}

std::string sentence(const Trials& trials, Goal goal, const std::vector<SpeedRange>& ranges) {
  if (ranges.empty()) return fmt::format("{}: nothing was measured.", words_for(goal));
  if (ranges.size() == 1)
    return fmt::format("{}: choose {} on every disk.", words_for(goal),
                       to_text(trials, ranges.front().choice));
  std::string text = fmt::format("{}: on disks ", words_for(goal));
  for (std::size_t i = 0; i + 1 < ranges.size(); ++i)
    text += fmt::format("{}slower than {} choose {}", i == 0 ? "" : "; else ",
                        speed_text(ranges[i].fastest), to_text(trials, ranges[i].choice));
  return text + fmt::format("; else {}.", to_text(trials, ranges.back().choice));
}

}  // namespace plait::tune
