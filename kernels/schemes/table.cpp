#include "schemes/table.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

#include "plait/error.h"

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

const SchemeTraits& traits_of(Scheme scheme) noexcept {
  return kTraits[static_cast<std::size_t>(scheme)];
}

SchemeTraits traits_of(const SubdivideOptions& options) {
  if (options.own_scheme == nullptr) return traits_of(options.scheme);
  const OneRing<float>& rule = options.own_scheme->rule<float>();
  return {.name = options.own_scheme->name(),
          .reach = 1,
          .moves_even = rule.moves_even(),
          .has_limits = rule.has_limits()};
}

std::string_view to_string(Scheme scheme) noexcept { return traits_of(scheme).name; }

std::string scheme_names() {
  return names_of([](const SchemeTraits&) { return true; });
}

std::string limit_scheme_names() {
  return names_of([](const SchemeTraits& scheme) { return scheme.has_limits; });
}

Scheme scheme_from_name(std::string_view name) {
  for (std::size_t i = 0; i < kTraits.size(); ++i)
    if (name == kTraits[i].name) return static_cast<Scheme>(i);
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("scheme '{}': expected {}", name, scheme_names()));
}

PLAIT_END_NAMESPACE
