#include "mesh/files/lost_digits.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "mesh/narrowing.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Half of what one more in the last digit of the text would be.
double half_of_last_digit(std::string_view word) {
  const std::size_t exponent_at = std::min(word.find_first_of("eE"), word.size());
  const std::string_view digits = word.substr(0, exponent_at);
  int exponent = 0;
  if (exponent_at < word.size()) {
    std::string_view text = word.substr(exponent_at + 1);
    if (text.starts_with('+')) text.remove_prefix(1);
    std::from_chars(text.data(), text.data() + text.size(), exponent);
  }
  const std::size_t point = digits.find('.');
  const double decimals =
      point == std::string_view::npos ? 0 : static_cast<double>(digits.size() - point - 1);
  return 0.5 * std::pow(10, exponent - decimals);
}

}  // namespace

void LostDigits::add(std::string_view word, double value) {
  const double change = std::fabs(as_float32(value) - value);
  // A part in 1e9 more, because neither of the numbers is exact.
  if (!(change > half_of_last_digit(word) * (1 + 1e-9)) || !std::isfinite(change)) return;
  ++count_;
  largest_change_ = std::max(largest_change_, change);
}

std::string LostDigits::text() const {
  return fmt::format(
      "{} numbers have more digits than float, the type that the header names, keeps (the largest "
      "change is {:.3g}): with double in the header all digits stay",
      count_, largest_change_);
}

PLAIT_END_NAMESPACE
