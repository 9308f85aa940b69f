#include "tune/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "plait/error.h"

namespace plait::tune {
namespace {

constexpr std::array<std::pair<Goal, std::string_view>, 5> kNames = {
    {{Goal::kRead, "read"},
     {Goal::kWrite, "write"},
     {Goal::kUpdate, "update"},
     {Goal::kSize, "size"},
     {Goal::kBalanced, "balanced"}}};

}  // namespace

std::string_view to_string(Goal goal) noexcept {
  return std::ranges::find(kNames, goal, [](const auto& each) { return each.first; })->second;
}

Goal goal_from_name(std::string_view name) {
  for (const auto& [goal, goal_name] : kNames)
    if (name == goal_name) return goal;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose a goal: expected read, write, update, size or balanced, found "
                          "\"{}\"",
                          name));
}

double cost(Goal goal, const Costs& costs) {
  switch (goal) {
    case Goal::kRead:
      return costs.read_seconds;
    case Goal::kWrite:
      return costs.write_seconds;
    case Goal::kUpdate:
      return costs.read_seconds + costs.write_seconds;
    case Goal::kSize:
      return costs.stored_bytes;
    case Goal::kBalanced:
      break;
  }
  return std::cbrt(costs.read_seconds * costs.write_seconds * costs.stored_bytes);
}

}  // namespace plait::tune
