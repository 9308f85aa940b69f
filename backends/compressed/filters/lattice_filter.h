// backends/compressed/filters/lattice_filter.h: numbers that were rounded to multiples of a step,
// as small integers. docs/filters/lattice.md describes it byte for byte.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/number_lattice.h"
#include "compressed/filters/ordered_words.h"
#include "compressed/filters/residuals.h"
#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Options: the step. Errors: kInvalidArgument for others, and for a step outside of kLeastStep to
/// kMostStep; kNotSupported for records other than float32 or float64.
std::unique_ptr<Filter> make_lattice_filter(std::string_view options, const FilterLevel& level);

/// The step of a filter's options. Errors: as make_lattice_filter().
double step_from_text(std::string_view filter, std::string_view text);

/// residual() and from_residual() of residuals.h, in steps of the lattice.
template <class Number>
[[gnu::always_inline]] inline BitsOf<Number> lattice_residual(const NumberLattice<Number>& lattice,
                                                              Number number, Number prediction) {
  return zigzag<kBitsOf<Number>>(
      static_cast<BitsOf<Number>>(lattice.word(number) - lattice.predicted_word(prediction)));
}
template <class Number>
[[gnu::always_inline]] inline Number from_lattice_residual(const NumberLattice<Number>& lattice,
                                                           BitsOf<Number> residual,
                                                           Number prediction) {
  return lattice.number_of_word(static_cast<BitsOf<Number>>(
      lattice.predicted_word(prediction) + from_zigzag<kBitsOf<Number>>(residual)));
}

PLAIT_END_NAMESPACE
