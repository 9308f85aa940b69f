#include "schemes/table.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/text.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr auto kTraits = []<class... Schemes>(std::tuple<Schemes...>*) {
  return std::array{Schemes::kTraits...};
}(static_cast<LibrarySchemes*>(nullptr));

/// The names of the schemes that `has` is true of: "a", "a or b", "a, b or c".
std::string names_of(bool (*has)(const SchemeTraits&)) {
  std::vector<std::string_view> names;
  for (const SchemeTraits& scheme : kTraits)
    if (has(scheme)) names.push_back(scheme.name);
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace

std::span<const SchemeTraits> schemes() noexcept { return kTraits; }

Scheme::Scheme(const OneRingScheme& rule) : own_(std::make_shared<const OneRingScheme>(rule)) {}

SchemeTraits traits_of(const Scheme& scheme) {
  if (scheme.own() == nullptr) return kTraits[static_cast<std::size_t>(scheme.of_library())];
  const OneRing<float>& rule = scheme.own()->rule<float>();
  return {.name = scheme.own()->name(),
          .ring_count = 1,
          .moves_even = rule.moves_even(),
          .has_limits = rule.has_limits()};
}

std::string_view to_string(const Scheme& scheme) { return traits_of(scheme).name; }

std::string scheme_names() {
  return names_of([](const SchemeTraits&) { return true; });
}

std::string limit_scheme_names() {
  return names_of([](const SchemeTraits& scheme) { return scheme.has_limits; });
}

LibraryScheme scheme_from_name(std::string_view name) {
  for (std::size_t i = 0; i < kTraits.size(); ++i)
    if (name == kTraits[i].name) return static_cast<LibraryScheme>(i);
  std::array<std::string_view, kTraits.size()> names;
  std::ranges::transform(kTraits, names.begin(), &SchemeTraits::name);
  throw unknown_name("scheme", name, names);
}

PLAIT_END_NAMESPACE
