// mesh/files/lost_digits.h: numbers in texts that have more digits than their type keeps.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The numbers of one property whose type is float.
class LostDigits {
 public:
  /// `value` is the number that `word` shows. Only digits that are shown count: a float that was
  /// written with nine digits or fewer loses none.
  void add(std::string_view word, double value);
  std::uint64_t count() const { return count_; }
  /// "18 numbers have more digits than ... keeps ...".
  std::string text() const;

 private:
  std::uint64_t count_ = 0;
  double largest_change_ = 0;
};

PLAIT_END_NAMESPACE
