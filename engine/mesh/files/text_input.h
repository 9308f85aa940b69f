// text_input.h: words, lines and numbers of an ascii mesh file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "mesh/files/input.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct TextRules {
  bool hash_comments = false;            ///< '#' starts a comment that runs to the end of the line
  bool backslash_continues = false;      ///< a backslash at the end of a line joins the next one
  bool divides_long_words = false;       ///< beyond kMaxWordBytes, which is an error otherwise
  std::string_view digits_comment = {};  ///< see hexadecimal_digits(); begins with '#'
};

/// A cursor over an Input. Lines end in \n, \r\n or \r; line() counts them from 1. Padding behind
/// the text (Input::pass_padding) is no text.
class TextInput {
 public:
  static constexpr std::size_t kMaxWordBytes = 4096;

  TextInput(Input& input, TextRules rules, std::uint64_t first_line = 1)
      : input_(input), rules_(rules), line_(first_line) {}

  std::uint64_t line() const { return line_; }
  Input& input() const { return input_; }
  /// Those of all comments so far that begin with TextRules::digits_comment, behind it.
  std::uint64_t hexadecimal_digits() const { return hexadecimal_digits_; }

  /// The next word of this line, empty at its end; valid until the next call.
  /// Errors: kInvalidArgument for a word longer than kMaxWordBytes.
  std::string_view word();
  /// Skips the rest of this line and goes to the next line that has a word. Returns false if the
  /// input ends before.
  bool next_line();
  /// Goes to the next word, on this line or a later one. Returns false if the input ends before.
  bool seek_word();

  /// Throws kInvalidArgument with "read PATH, line N: ELEMENT: expected EXPECTED, found FOUND". An
  /// empty `found` means the end of the line.
  [[noreturn]] void refuse(std::string_view element, std::string_view expected,
                           std::string_view found) const;
  /// Throws the same error with the end of the file as found.
  [[noreturn]] void refuse_end(std::string_view element, std::string_view expected) const;

 private:
  /// Skips blanks, comments and continued line ends. Returns the next byte, or nothing at the end
  /// of the input.
  std::optional<char> peek();
  void pass_line_end(char first);
  void pass_comment();
  /// Whether the '#' behind `length` bytes is that of 1.#INF or its like, and begins no comment.
  bool is_part_of_number(std::size_t length);

  Input& input_;
  TextRules rules_;
  std::uint64_t line_;
  std::uint64_t hexadecimal_digits_ = 0;
};

/// A decimal or scientific number, "nan" and "inf" included. Returns nothing if `word` is not a
/// number or is too large for a double. A number too small for a double gives zero. Independent of
/// the locale.
std::optional<double> parse_plain_number(std::string_view word);
/// A number in the forms of other run-time systems, or nothing (foreign_numbers.cpp).
std::optional<double> parse_foreign_number(std::string_view word);
/// A number in either form.
inline std::optional<double> parse_number(std::string_view word) {
  const std::optional<double> number = parse_plain_number(word);
  return number ? number : parse_foreign_number(word);
}
std::optional<std::int64_t> parse_integer(std::string_view word);

PLAIT_END_NAMESPACE
