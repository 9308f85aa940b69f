// Numbers in words that std::from_chars does not read, as other run-time systems print them.
//   1.#INF  -1.#IND00  1.#QNAN  1.#SNAN   Windows before 2015: infinity, and no number. A format of
//                                         few digits rounds the letters: 1.#IO, 1.#J, 1.#R, 1.$
//   1.5D+03  0.15-102                     Fortran: an exponent of double precision, and one of
//   three
//                                         digits
//   NaNQ  NaNS                            AIX
// Sources: Microsoft, "CRT: printf of infinities and NaNs", 2013; ISO/IEC 1539-1:2010 (Fortran),
// 10.7.2.3. Pinned by tests/engine/mesh/foreign_numbers_test.cpp.
#include <algorithm>
#include <array>
#include <cctype>
#include <limits>

#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::string_view kDigits = "0123456789";

std::string lower(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// `text` without the sign that it begins with.
std::string_view without_sign(std::string_view text) {
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  return text;
}

/// "e+000" at the end, which the format %e adds to every number.
std::string_view without_exponent(std::string_view text) {
  const std::size_t e = text.rfind('e');
  if (e == std::string_view::npos) return text;
  const std::string_view exponent = without_sign(text.substr(e + 1));
  const bool is_exponent =
      !exponent.empty() && exponent.find_first_not_of(kDigits) == std::string_view::npos;
  return is_exponent ? text.substr(0, e) : text;
}

std::optional<double> windows_number(std::string_view word) {
  constexpr auto kNone = std::to_array<std::string_view>(
      {"#ind", "#qnan", "#snan", "#io", "#j", "#qnb", "#qo", "#r", "#snb", "#so", "#t", "$"});
  std::string_view mark = without_sign(word);
  if (!mark.starts_with("1.#") && !mark.starts_with("1.$")) return std::nullopt;
  mark = without_exponent(mark.substr(2));
  mark = mark.substr(0, mark.find_last_not_of('0') + 1);
  if (mark == "#inf")
    return word.starts_with('-') ? -std::numeric_limits<double>::infinity()
                                 : std::numeric_limits<double>::infinity();
  if (std::ranges::find(kNone, mark) == kNone.end()) return std::nullopt;
  return std::numeric_limits<double>::quiet_NaN();
}

std::optional<double> fortran_number(std::string_view word) {
  const std::size_t letter = word.find_first_of("dq");
  if (letter != std::string_view::npos) {
    if (word.substr(0, letter).find_first_not_of("+-.0123456789") != std::string_view::npos)
      return std::nullopt;
    std::string with_e(word);
    with_e[letter] = 'e';
    return parse_plain_number(with_e);
  }
  constexpr std::size_t kExponent = 4;  // a sign and three digits
  if (word.size() < kExponent + 2 || word.find('.') == std::string_view::npos) return std::nullopt;
  const std::size_t at = word.size() - kExponent;
  if ((word[at] != '+' && word[at] != '-') ||
      word.substr(0, at).find_first_not_of("+-.0123456789") != std::string_view::npos)
    return std::nullopt;
  return parse_plain_number(std::string(word.substr(0, at)) + "e" + std::string(word.substr(at)));
}

}  // namespace

std::optional<double> parse_foreign_number(std::string_view word) {
  const std::string small = lower(word);
  if (const auto number = windows_number(small)) return number;
  if (const std::string_view name = without_sign(small); name == "nanq" || name == "nans")
    return std::numeric_limits<double>::quiet_NaN();
  return fortran_number(small);
}

PLAIT_END_NAMESPACE
