// text_input.h: words, lines and numbers of an ascii mesh file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "input.h"

namespace plait {

struct TextRules {
  bool hash_comments = false;        ///< '#' starts a comment that runs to the end of the line
  bool backslash_continues = false;  ///< a backslash at the end of a line joins the next one
};

/// A cursor over an Input. Lines end in \n, \r\n or \r; line() counts them from 1.
class TextInput {
 public:
  static constexpr std::size_t kMaxWordBytes = 4096;

  TextInput(Input& input, TextRules rules, std::uint64_t first_line = 1)
      : input_(input), rules_(rules), line_(first_line) {}

  std::uint64_t line() const { return line_; }
  Input& input() const { return input_; }

  /// The next word of this line, empty at its end; valid until the next call.
  /// Errors: kInvalidArgument for a word longer than kMaxWordBytes.
  std::string_view word();
  /// Passes what is left of this line and goes to the next one that has a word; false if the
  /// input ends before.
  bool next_line();
  /// Goes to the next word, on this line or a later one; false if the input ends before.
  bool seek_word();

  /// "read PATH, line N: WHAT: expected EXPECTED, found FOUND" as a kInvalidArgument, with the end
  /// of the line for an empty `found`.
  [[noreturn]] void refuse(std::string_view element, std::string_view expected,
                           std::string_view found) const;
  /// The same where the end of the file was found.
  [[noreturn]] void refuse_end(std::string_view element, std::string_view expected) const;

 private:
  /// Passes blanks, comments and joined line ends; then the next byte, or nothing at the end of
  /// the input.
  std::optional<char> peek();
  void pass_line_end(char first);
  void pass_comment();

  Input& input_;
  TextRules rules_;
  std::uint64_t line_;
};

/// A decimal or scientific number, "nan" and "inf" included; nothing if `word` is none or larger
/// than a double. Independent of the locale. What is too small for a double is zero.
std::optional<double> parse_number(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace plait
