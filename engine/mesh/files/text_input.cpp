#include "mesh/files/text_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }
bool is_padding(char c) { return c == '\0' || c == '\x1a'; }
/// Most bytes of a text are above the blank, which one comparison tells.
bool ends_word(char c) {
  return static_cast<unsigned char>(c) <= ' ' && (is_blank(c) || is_line_end(c) || is_padding(c));
}

/// Removes a plus sign, which std::from_chars does not accept. Returns nothing if another sign
/// follows.
std::optional<std::string_view> without_plus(std::string_view word) {
  if (!word.starts_with('+')) return word;
  word.remove_prefix(1);
  return word.starts_with('-') ? std::nullopt : std::optional(word);
}

/// For a decimal number outside the range of double: whether it is too small (not too large). The
/// sign of the exponent decides it, after the number is written as 0.d... times a power of ten with
/// d > 0.
bool is_below_doubles(std::string_view number) {
  const std::size_t mantissa_end = std::min(number.find_first_of("eE"), number.size());
  const std::string_view mantissa = number.substr(0, mantissa_end);
  const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size()));
  const auto digit = static_cast<std::int64_t>(mantissa.find_first_of("123456789"));
  const std::int64_t place = digit < point ? point - digit : point - digit + 1;
  if (mantissa_end == number.size()) return place < 0;

  std::string_view text = number.substr(mantissa_end + 1);
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int32_t exponent = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
  // If the exponent exceeds 64 bits, its sign decides: a word is too short to contain that many
  // digits before or after its point.
  return error == std::errc() ? place + exponent < 0 : text.starts_with('-');
}

}  // namespace

void TextInput::pass_line_end(char first) {
  input_.consume(1);
  if (first == '\r' && input_.ensure(1) && input_.unread().front() == '\n') input_.consume(1);
  ++line_;
}

void TextInput::pass_comment() {
  const std::string_view mark = rules_.digits_comment;
  const bool counts =
      !mark.empty() && input_.ensure(mark.size()) && input_.unread().starts_with(mark);
  if (counts) input_.consume(mark.size());
  do {
    const std::string_view text = input_.unread();
    std::size_t length = 0;
    while (length < text.size() && !is_line_end(text[length])) ++length;
    if (counts)
      hexadecimal_digits_ += static_cast<std::uint64_t>(
          std::count_if(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(length),
                        [](char c) { return std::isxdigit(static_cast<unsigned char>(c)) != 0; }));
    input_.consume(length);
    if (length < text.size()) return;
  } while (input_.fill());
}

std::optional<char> TextInput::peek() {
  for (;;) {
    const std::string_view text = input_.unread();
    std::size_t blanks = 0;
    while (blanks < text.size() && is_blank(text[blanks])) ++blanks;
    input_.consume(blanks);
    if (blanks == text.size()) {
      if (!input_.fill()) return std::nullopt;
      continue;
    }
    const char c = text[blanks];
    if (c == '#' && rules_.hash_comments) {
      pass_comment();
    } else if (c == '\\' && rules_.backslash_continues && input_.ensure(2) &&
               is_line_end(input_.unread()[1])) {
      input_.consume(1);
      pass_line_end(input_.unread().front());
    } else if (is_padding(c) && input_.pass_padding()) {
      return std::nullopt;
    } else {
      return c;
    }
  }
}

bool TextInput::is_part_of_number(std::size_t length) {
  constexpr std::size_t kLongestOne = 3, kLongestMark = 16;
  if (length > kLongestOne) return false;
  input_.ensure(length + kLongestMark);  // at the end there may be fewer
  std::string_view number = input_.unread().substr(0, length + kLongestMark);
  number = number.substr(0, number.find_first_of(" \t\v\f\r\n"));
  return parse_foreign_number(number).has_value();
}

std::string_view TextInput::word() {
  const std::optional<char> first = peek();
  if (!first || is_line_end(*first)) return {};
  std::size_t length = 1;
  for (;;) {
    const std::string_view text = input_.unread();
    while (length < text.size() && !ends_word(text[length]) &&
           !(text[length] == '#' && rules_.hash_comments) &&
           !(text[length] == '\\' && rules_.backslash_continues))
      ++length;
    if (length < text.size() && text[length] == '#' && is_part_of_number(length)) {
      ++length;
      continue;
    }
    if (length > kMaxWordBytes && rules_.divides_long_words) {
      length = kMaxWordBytes;
      break;
    }
    if (length > kMaxWordBytes)
      refuse("word", fmt::format("at most {} characters", kMaxWordBytes), text.substr(0, length));
    if (length < text.size() || !input_.fill()) break;
  }
  const std::string_view result = input_.unread().substr(0, length);
  input_.consume(length);
  return result;
}

bool TextInput::next_line() {
  for (;;) {
    const std::optional<char> c = peek();
    if (!c) return false;
    if (!is_line_end(*c)) {
      word();
      continue;
    }
    pass_line_end(*c);
    const std::optional<char> first = peek();
    if (first && !is_line_end(*first)) return true;
  }
}

bool TextInput::seek_word() {
  const std::optional<char> c = peek();
  if (!c) return false;
  return !is_line_end(*c) || next_line();
}

void TextInput::refuse(std::string_view element, std::string_view expected,
                       std::string_view found) const {
  input_.refuse_at_line(line_,
                        fmt::format("{}: expected {}, found {}", element, expected,
                                    found.empty() ? "the end of the line" : in_quotes(found)));
}

void TextInput::refuse_end(std::string_view element, std::string_view expected) const {
  input_.refuse_at_line(
      line_, fmt::format("{}: expected {}, found the end of the file", element, expected));
}

std::optional<double> parse_plain_number(std::string_view word) {
  const std::optional<std::string_view> number = without_plus(word);
  if (!number || number->empty()) return std::nullopt;
  const char* const last = number->data() + number->size();
  double value = 0;
  const auto [end, error] = std::from_chars(number->data(), last, value);
  if (end != last) return std::nullopt;
  if (error == std::errc()) return value;
  return error == std::errc::result_out_of_range && is_below_doubles(*number) ? std::optional(0.0)
                                                                              : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  const std::optional<std::string_view> number = without_plus(word);
  if (!number || number->empty()) return std::nullopt;
  const char* const last = number->data() + number->size();
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(number->data(), last, value);
  if (error != std::errc() || end != last) return std::nullopt;
  return value;
}

PLAIT_END_NAMESPACE
