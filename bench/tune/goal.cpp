#include "tune/goal.h"

#include <cmath>

#include "base/name_table.h"

namespace plait::tune {
namespace {

constexpr NameTable<Goal, 5> kGoals("goal", {{Goal::kRead, "read"},
                                             {Goal::kWrite, "write"},
                                             {Goal::kUpdate, "update"},
                                             {Goal::kSize, "size"},
                                             {Goal::kBalanced, "balanced"}});
constexpr NameTable<Goal, 5> kWords("goal",
                                    {{Goal::kRead, "For a full read"},
                                     {Goal::kWrite, "For a full write"},
                                     {Goal::kUpdate,
                                      "For reading, changing and writing all records"},
                                     {Goal::kSize, "For size"},
                                     {Goal::kBalanced, "For reading, writing and size together"}});

}  // namespace

std::string_view to_string(Goal goal) noexcept { return kGoals.name_of(goal); }
std::string_view words_for(Goal goal) noexcept { return kWords.name_of(goal); }
Goal goal_from_name(std::string_view name) { return kGoals.find(name); }

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
