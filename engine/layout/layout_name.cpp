#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include "plait/error.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::array<std::pair<LayoutKind, std::string_view>, 5> kNames{{
    {LayoutKind::kGiven, "given"},
    {LayoutKind::kSpatial, "spatial"},
    {LayoutKind::kHilbert, "hilbert"},
    {LayoutKind::kRcm, "rcm"},
    {LayoutKind::kAutomatic, "auto"},
}};

}  // namespace

std::string_view to_string(LayoutKind kind) noexcept {
  for (const auto& [known, name] : kNames)
    if (known == kind) return name;
  return "unknown";
}

LayoutKind layout_from_name(std::string_view name) {
  std::string known_names;
  for (const auto& [kind, known] : kNames) {
    if (known == name) return kind;
    known_names += fmt::format("{}{}", known_names.empty() ? "" : ", ", known);
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("layout: expected one of {}, found \"{}\"", known_names, name));
}

PLAIT_END_NAMESPACE
