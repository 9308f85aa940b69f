// The list of the library's schemes. No other code names all of them.
#pragma once

#include <array>
#include <cstddef>
#include <tuple>
#include <utility>

#include "plait/detail/one_ring.h"
#include "plait/detail/scheme.h"
#include "schemes/butterfly.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// In the order of their numbers.
using LibrarySchemes = std::tuple<LoopScheme, ButterflyScheme, MidpointScheme>;

template <std::size_t... kNumbers>
constexpr bool are_in_order(std::index_sequence<kNumbers...>) {
  return ((std::tuple_element_t<kNumbers, LibrarySchemes>::kScheme == LibraryScheme{kNumbers}) &&
          ...);
}
constexpr std::size_t kSchemeCount = std::tuple_size_v<LibrarySchemes>;
static_assert(are_in_order(std::make_index_sequence<kSchemeCount>()));

/// Calls visit(rule) with the rule of a scheme for points of `Real`, and returns its result. A run
/// calls it once, so the code below it does not depend on the scheme.
template <class Real, class Visit>
auto with_rule(const Scheme& scheme, Visit visit) {
  if (scheme.own() != nullptr) return visit(scheme.own()->template rule<Real>());
  using Result = decltype(visit(LoopScheme::rule<Real>()));
  using Call = Result (*)(Visit&);
  constexpr auto calls = []<class... Schemes>(std::tuple<Schemes...>*) {
    return std::array<Call, sizeof...(Schemes)>{
        [](Visit& visit_it) -> Result { return visit_it(Schemes::template rule<Real>()); }...};
  }(static_cast<LibrarySchemes*>(nullptr));
  return calls.at(static_cast<std::size_t>(scheme.of_library()))(visit);
}
PLAIT_END_NAMESPACE
