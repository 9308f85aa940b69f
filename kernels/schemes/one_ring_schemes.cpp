#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "plait/detail/scheme.h"
#include "plait/error.h"
#include "plait/own_rule.h"
#include "schemes/library_rule.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Rule>
OneRingScheme library_scheme(std::string_view name) {
  return {std::string(name), library_rule<Rule, float>(), library_rule<Rule, double>()};
}

template <class Real>
bool keeps_promises(const OneRing<Real>& rule) {
  // Numbers whose sums and products must be rounded, and give other bits in another order.
  const Vector3<Real> a{Real(0.1), Real(-7.3), Real(1e5)}, b{Real(3.7), Real(0.013), Real(-0.6)},
      c{Real(-1.9), Real(511.1), Real(1e-3)}, d{Real(0.77), Real(-2.3), Real(41.7)};
  const Vector3<Real> made = rule.odd(a, b, c, d);
  return rule.odd(b, a, c, d) == made && rule.odd(a, b, d, c) == made &&
         rule.odd(b, a, d, c) == made && rule.odd_border(a, b) == rule.odd_border(b, a) &&
         (!rule.reads_ends_only() || rule.odd_border(a, b) == made);
}

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_';
}

void check_name(std::string_view name) {
  const auto wrong = std::ranges::find_if_not(name, is_name_character);
  if (!name.empty() && name.size() <= kMostSchemeNameBytes && wrong == name.end()) return;
  // A terminal may take other bytes for commands, and a message is one line.
  std::string shown(name.substr(0, 40));
  std::ranges::replace_if(
      shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  const std::string found =
      wrong == name.end() ? fmt::format("{} bytes", name.size())
                          : fmt::format("byte 0x{:02x} at {}", static_cast<unsigned char>(*wrong),
                                        wrong - name.begin());
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("own scheme '{}': expected a name of 1 to {} letters, digits, '-' and "
                          "'_', found {}",
                          shown, kMostSchemeNameBytes, found));
}

}  // namespace

const OneRingScheme& loop_scheme() {
  static const OneRingScheme scheme = library_scheme<LoopRule>(LoopScheme::kTraits.name);
  return scheme;
}

const OneRingScheme& midpoint_scheme() {
  static const OneRingScheme scheme = library_scheme<MidpointRule>(MidpointScheme::kTraits.name);
  return scheme;
}

void check_own_scheme(const OneRingScheme& scheme) {
  check_name(scheme.name());
  const std::string& name = scheme.name();
  if (std::ranges::any_of(schemes(), [&](const SchemeTraits& of) { return of.name == name; }))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("own scheme '{}': the library has a scheme of this name", name));
  if (!keeps_promises(scheme.rule<float>()) || !keeps_promises(scheme.rule<double>()))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("own scheme '{}': odd or odd_border gives other bits when the ends of "
                            "the edge, or the vertices opposite it, change places{}",
                            name,
                            scheme.rule<float>().reads_ends_only()
                                ? ", or odd is not odd_border though the rule reads ends only"
                                : ""));
}

PLAIT_END_NAMESPACE
