// base/number_lattice.h: the multiples of a step as floating-point numbers, and a map of all words
// in which neighbours on this lattice are neighbours. A lossy attribute is rounded to such a
// lattice (plait/extend/rounding.h), and filters store differences of the words
// (docs/filters/lattice.md).
//
// The number with index k is k * step, computed in double and rounded to the attribute's type, for
// |k| <= kMost. kMost is so small that a number's own spacing is at most half a step: so numbers
// with different indices differ, and index() inverts number().
//
// Call these functions only while a DefaultArithmetic exists (base/default_arithmetic.h). All
// functions are inlined and free of branches, so that loops over numbers become vector loops.
// Pinned by tests/engine/base/number_lattice_test.cpp, with PLAIT_LONG=1 for all 2^32 words.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Steps outside of this range are refused. Inside, no number of the lattice but 0 is denormal, and
/// none is infinite.
constexpr double kLeastStep = 0x1p-120, kMostStep = 0x1p100;

/// The lattice of float or double numbers with one step. Immutable.
template <class Number>
class NumberLattice {
  static_assert(std::is_same_v<Number, float> || std::is_same_v<Number, double>);

 public:
  using Word = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
  /// The largest index. Beyond kMost * step, numbers are not on the lattice.
  static constexpr std::int64_t kMost = std::int64_t{1} << (sizeof(Number) == 4 ? 22 : 40);
  /// The word of the number 0.
  static constexpr Word kCentre = Word{1} << (8 * sizeof(Number) - 1);

  /// REQUIRES: kLeastStep <= step <= kMostStep.
  explicit NumberLattice(double step) noexcept : step_(step), inverse_(1 / step) {}
  double step() const noexcept { return step_; }

  /// The number with this index. REQUIRES: |index| <= kMost.
  [[gnu::always_inline]] Number number(std::int64_t index) const noexcept {
    return static_cast<Number>(from_index(index) * step_);
  }
  /// The index of the lattice's number nearest to x, and whether there is one; for any x.
  struct Nearest {
    std::int64_t index;  ///< of no meaning unless `exists`
    bool exists;
  };
  [[gnu::always_inline]] Nearest nearest(Number x) const noexcept {
    // Adding kShift rounds to a whole number, half to even, and puts it into the lowest bits.
    const double shifted = static_cast<double>(x) * inverse_ + kShift;
    const double whole = shifted - kShift;
    return {to_index(shifted), whole >= -kLimit && whole <= kLimit};
  }

  /// Any word as an integer: kCentre + index for numbers of the lattice, and the place among all
  /// numbers (ordered()) for the others. Only the places kCentre - kMost to kCentre + kMost are
  /// taken by indices: denormal numbers are there. The two sets of places are
  /// exchanged, so applying the map twice gives the number back.
  [[gnu::always_inline]] Word word(Number x) const noexcept {
    const Word bits = std::bit_cast<Word>(x), place = ordered(bits);
    const Nearest found = nearest(x);
    const Number at = number(found.exists ? found.index : 0);
    const Word index = kCentre + static_cast<Word>(found.index);
    const bool on_lattice = found.exists & (std::bit_cast<Word>(at) == bits);
    const Word other = is_index(place) ? ordered(std::bit_cast<Word>(at_word(place))) : place;
    return on_lattice ? index : other;
  }
  /// The inverse of word().
  [[gnu::always_inline]] Number number_of_word(Word word) const noexcept {
    const Number at = at_word(word);
    const Number plain = std::bit_cast<Number>(from_ordered(word));
    const Nearest found = nearest(plain);
    const Number near = number(found.exists ? found.index : 0);
    const bool on_lattice =
        found.exists & (std::bit_cast<Word>(near) == std::bit_cast<Word>(plain));
    const Word displaced = from_ordered(kCentre + static_cast<Word>(found.index));
    const Number other = on_lattice ? std::bit_cast<Number>(displaced) : plain;
    return is_index(word) ? at : other;
  }
  /// The word that a number near `prediction` is expected to have. Any prediction is allowed.
  [[gnu::always_inline]] Word predicted_word(Number prediction) const noexcept {
    const Nearest found = nearest(prediction);
    const Number counted = prediction == prediction ? prediction : Number{0};
    return found.exists ? kCentre + static_cast<Word>(found.index)
                        : ordered(std::bit_cast<Word>(counted));
  }

  /// The place of a number with these bits among all numbers: 2^31 (2^63) is that of 0.
  [[gnu::always_inline]] static constexpr Word ordered(Word bits) noexcept {
    return bits ^ ((Word{} - (bits >> (8 * sizeof(Word) - 1))) | kCentre);
  }
  [[gnu::always_inline]] static constexpr Word from_ordered(Word place) noexcept {
    return place ^ (((place >> (8 * sizeof(Word) - 1)) - 1) | kCentre);
  }

 private:
  static constexpr double kShift = 0x1.8p52, kLimit = static_cast<double>(kMost);
  static constexpr std::int64_t kShiftBits = 0x4338000000000000;

  [[gnu::always_inline]] static std::int64_t to_index(double shifted) noexcept {
    return static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(shifted) -
                                     static_cast<std::uint64_t>(kShiftBits));
  }
  [[gnu::always_inline]] static double from_index(std::int64_t index) noexcept {
    return std::bit_cast<double>(static_cast<std::uint64_t>(index) +
                                 static_cast<std::uint64_t>(kShiftBits)) -
           kShift;
  }
  [[gnu::always_inline]] static bool is_index(Word word) noexcept {
    return static_cast<Word>(word - kCentre + static_cast<Word>(kMost)) <=
           static_cast<Word>(2 * kMost);
  }
  /// The number of an index word; of no meaning for other words.
  [[gnu::always_inline]] Number at_word(Word word) const noexcept {
    using Signed = std::make_signed_t<Word>;
    const auto index = static_cast<Signed>(static_cast<Word>(word - kCentre));
    return number(is_index(word) ? index : 0);
  }

  double step_, inverse_;
};

PLAIT_END_NAMESPACE
