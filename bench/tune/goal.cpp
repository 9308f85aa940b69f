#include "tune/goal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "plait/error.h"

namespace plait::tune {
namespace {

struct Described {
  Goal goal;
  std::string_view name, words;
};
constexpr std::array<Described, 5> kGoals = {
    {{Goal::kRead, "read", "For a full read"},
     {Goal::kWrite, "write", "For a full write"},
     {Goal::kUpdate, "update", "For reading, changing and writing all records"},
     {Goal::kSize, "size", "For size"},
     {Goal::kBalanced, "balanced", "For reading, writing and size together"}}};

const Described& description_of(Goal goal) noexcept {
  return *std::ranges::find(kGoals, goal, &Described::goal);
}

}  // namespace

std::string_view to_string(Goal goal) noexcept { return description_of(goal).name; }
std::string_view words_for(Goal goal) noexcept { return description_of(goal).words; }

Goal goal_from_name(std::string_view name) {
  if (const auto found = std::ranges::find(kGoals, name, &Described::name); found != kGoals.end())
    return found->goal;
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
