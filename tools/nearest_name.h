// tools/nearest_name.h: what somebody who mistyped a name may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plait {

/// The one of `names` that the fewest insertions, removals, replacements and swaps of neighbours
/// make out of `name`; empty if that takes more than two, or as many as `name` has letters.
/// The first of equals. Pinned by tests/tools/arguments_test.cpp.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace plait
