// compressed/filters/built_in_filters.h: how the registry makes each built-in filter.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "base/number_lattice.h"
#include "compressed/filters/ordered_words.h"
#include "compressed/filters/residuals.h"
#include "plait/extend/filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Groups the bytes of components by significance.

/// Puts the first bytes of all components first, then all second bytes, and so on. Bytes after the
/// last whole component keep their place. REQUIRES: `component_bytes` is 2, 4 or 8.
std::unique_ptr<Filter> make_shuffle_filter(std::size_t component_bytes);

// Differences from straight lines down the columns of
// a slot. docs/filters/columns.md has the bytes.

/// `level.geometry` may be null; then the filter is not used. Errors: kNotSupported unless the
/// components are float32 or float64.
std::unique_ptr<Filter> make_columns_filter(std::string_view options, const FilterLevel& level);

// Predicts the vertices of a block from the coarser
// levels. docs/filters/hierarchy.md describes it byte for byte.

/// Options: "butterfly" or nothing, and "midpoint" (compressed/filters/edge_lattice.h), each with
/// or without "step=STEP" for rounded numbers (compressed/filters/built_in_filters.h). Errors:
/// kInvalidArgument for others; kNotSupported for records other than 1 to 4 float32 or float64.
std::unique_ptr<Filter> make_hierarchy_filter(std::string_view options, const FilterLevel& level);

// Numbers that were rounded to multiples of a step,
// as small integers. docs/filters/lattice.md describes it byte for byte.

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

// Predicts the normals of a block from positions.
// docs/filters/normals.md describes it byte for byte.

/// Options: the name of the attribute with the positions; "position" without options. Errors:
/// kNotSupported for records other than three float32, and if the store has no such attribute of
/// three float32 or float64 with the levels up to that of the block.
std::unique_ptr<Filter> make_normals_filter(std::string_view options, const FilterLevel& level);

PLAIT_END_NAMESPACE
