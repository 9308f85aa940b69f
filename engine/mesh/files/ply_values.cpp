#include "mesh/files/ply_values.h"

#include <fmt/format.h>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::string describe_place(const PlyPlace& place) {
  return fmt::format("{} {}", in_quotes(place.element), place.index);
}

std::string describe_rest(const PlyPlace& place) {
  return fmt::format("all {} of them", place.count);
}

}  // namespace

void BinaryPlyValues::refuse_at(std::uint64_t offset, std::string_view expected,
                                std::string_view found) const {
  input_.refuse_at_byte(
      offset, fmt::format("{}: expected {}, found {}", describe_place(place_), expected, found));
}

void BinaryPlyValues::refuse_end() const {
  refuse_at(input_.offset() + input_.unread().size(), describe_rest(place_), "the end of the file");
}

bool BinaryPlyValues::at_end() {
  while (input_.ensure(1)) {
    const char c = input_.unread().front();
    if (c != '\n' && c != '\r' && c != ' ') return false;
    input_.consume(1);
  }
  return true;
}

void TextPlyValues::begin_element(const PlyPlace& place) {
  place_ = place;
  if (!text_.seek_word()) refuse(describe_rest(place_), "the end of the file");
}

void TextPlyValues::end_element() {
  const std::string_view word = text_.word();
  if (!word.empty()) refuse("the end of the line", in_quotes(word));
}

double TextPlyValues::value(ComponentType) {
  word_ = text_.word();
  const std::optional<double> number = parse_number(word_);
  if (!number) refuse("a number", word_.empty() ? "the end of the line" : in_quotes(word_));
  return *number;
}

void TextPlyValues::refuse(std::string_view expected, std::string_view found) const {
  text_.input().refuse_at_line(text_.line(), fmt::format("{}: expected {}, found {}",
                                                         describe_place(place_), expected, found));
}

bool TextPlyValues::at_end() { return !text_.seek_word(); }

PLAIT_END_NAMESPACE
