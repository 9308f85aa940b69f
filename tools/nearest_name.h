// tools/nearest_name.h: suggests a name for a mistyped one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plait {

/// The name in `names` that needs the fewest edits of `name`; the first of equals. An edit inserts,
/// removes or replaces a letter, or swaps two neighbours. Empty if more than two edits are needed,
/// or as many as `name` has letters. Pinned by tests/tools/arguments_test.cpp.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace plait
