#include "option_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "base/text.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

[[noreturn]] void refuse_size_text(std::string_view text) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("read size \"{}\": expected a whole number of bytes below 2^64, such as "
                          "65536, 64KiB, 1.5GiB",
                          text));
}

/// The power of two that a unit stands for, or -1.
int unit_shift_of(std::string_view unit) {
  std::string lower(unit);
  std::ranges::transform(lower, lower.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  if (lower.empty() || lower == "b") return 0;
  if (lower == "k" || lower == "kb" || lower == "kib") return 10;
  if (lower == "m" || lower == "mb" || lower == "mib") return 20;
  if (lower == "g" || lower == "gb" || lower == "gib") return 30;
  if (lower == "t" || lower == "tb" || lower == "tib") return 40;
  return -1;
}

template <class Number>
bool parse_option_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::uint64_t parse_size(std::string_view text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  std::uint64_t whole = 0;
  if (!parse_option_number(text.substr(0, digits), whole)) refuse_size_text(text);
  std::string_view rest = text.substr(digits);
  std::string_view fraction;
  if (!rest.empty() && rest.front() == '.') {
    rest.remove_prefix(1);
    const std::size_t end = std::min(rest.find_first_not_of("0123456789"), rest.size());
    fraction = rest.substr(0, end);
    rest.remove_prefix(end);
    if (fraction.empty() || fraction.size() > 9) refuse_size_text(text);
  }
  if (rest.size() > 1 && rest.front() == ' ') rest.remove_prefix(1);
  const int shift = unit_shift_of(rest);
  if (shift < 0 || whole > (std::numeric_limits<std::uint64_t>::max() >> shift))
    refuse_size_text(text);
  std::uint64_t bytes = whole << shift;
  if (!fraction.empty()) {
    std::uint64_t numerator = 0, denominator = 1;
    parse_option_number(fraction, numerator);
    for (std::size_t digit = 0; digit < fraction.size(); ++digit) denominator *= 10;
    // A product of nine digits and forty bits can exceed 64 bits, so the fraction is first reduced
    // to lowest terms.
    const std::uint64_t common = std::gcd(numerator, denominator);
    if ((std::uint64_t{1} << shift) % (denominator / common) != 0) refuse_size_text(text);
    bytes += (std::uint64_t{1} << shift) / (denominator / common) * (numerator / common);
  }
  return bytes;
}

std::uint64_t parse_whole_number(std::string_view text, std::uint64_t first, std::uint64_t last) {
  std::uint64_t value = 0;
  if (!parse_option_number(text, value) || value < first || value > last)
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("expected a whole number from {} to {}, found \"{}\"", first, last, text));
  return value;
}

double parse_number(std::string_view text, double first, double last) {
  double value = 0;
  if (!parse_option_number(text, value) || !(value >= first && value <= last))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("expected a number from {} to {}, found \"{}\"", first, last, text));
  return value;
}

RelativeLength parse_relative_length(std::string_view text) {
  const bool is_percent = text.ends_with('%');
  if (is_percent) text.remove_suffix(1);
  return {parse_number(text, 0, std::numeric_limits<double>::max()), is_percent};
}

void require_extension(std::string_view verb, const std::filesystem::path& path,
                       std::string_view extension) {
  if (lower_extension(path) != extension)
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{} {}: expected a name that ends in {}",
                                                         verb, path.native(), extension));
}

PLAIT_END_NAMESPACE
