// bench/tune/goal.h: what shall be small.
#pragma once

#include <string_view>

namespace plait::tune {

enum class Goal : std::uint8_t { kRead, kWrite, kUpdate, kSize, kBalanced };
std::string_view to_string(Goal goal) noexcept;
/// "For a full read".
std::string_view words_for(Goal goal) noexcept;
/// Errors: kInvalidArgument; the message lists the goals.
Goal goal_from_name(std::string_view name);

struct Costs {
  double stored_bytes = 0, write_seconds = 0, read_seconds = 0;
};
/// The seconds of a full read or of a full write; of both, for changing all records; the stored
/// bytes; or, balanced, the cube root of their product, so that a tenth of each counts the same.
double cost(Goal goal, const Costs& costs);

}  // namespace plait::tune
