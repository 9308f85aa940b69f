#include "text_input.h"

#include <fmt/format.h>

#include <charconv>

namespace plait {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

}  // namespace

void TextInput::pass_line_end(char first) {
  input_.consume(1);
  if (first == '\r' && input_.ensure(1) && input_.unread().front() == '\n') input_.consume(1);
  ++line_;
}

void TextInput::pass_comment() {
  do {
    const std::string_view text = input_.unread();
    std::size_t length = 0;
    while (length < text.size() && !is_line_end(text[length])) ++length;
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
    } else {
      return c;
    }
  }
}

std::string_view TextInput::word() {
  const std::optional<char> first = peek();
  if (!first || is_line_end(*first)) return {};
  std::size_t length = 1;
  for (;;) {
    const std::string_view text = input_.unread();
    while (length < text.size() && !is_blank(text[length]) && !is_line_end(text[length]) &&
           !(text[length] == '#' && rules_.hash_comments) &&
           !(text[length] == '\\' && rules_.backslash_continues))
      ++length;
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

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  if (error == std::errc()) return value;
  if (error != std::errc::result_out_of_range) return std::nullopt;
  const bool tiny = word.find("e-") != std::string_view::npos ||
                    word.find("E-") != std::string_view::npos ||
                    word.substr(word.starts_with('-') ? 1 : 0).starts_with("0.");
  return tiny ? std::optional(0.0) : std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || word.empty()) return std::nullopt;
  return value;
}

}  // namespace plait
