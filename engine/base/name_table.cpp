#include "base/name_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The most characters of a name in a message, because a message is one line.
constexpr std::size_t kMostOfAName = 100;

}  // namespace

std::string join_names(std::span<const std::string_view> names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

Error unknown_name(std::string_view what, std::string_view name,
                   std::span<const std::string_view> names) {
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("unknown {} '{}', expected {}", what, name.substr(0, kMostOfAName),
                           join_names(names)));
}

PLAIT_END_NAMESPACE
