// ply_values.h: reads the numbers of a PLY body one after another, from text or from binary data.
// Both classes have the same members, so that ply.cpp needs only one loop over elements.
#pragma once

#include <array>
#include <cstring>
#include <string>
#include <string_view>

#include "base/number_type.h"
#include "mesh/files/ply_header.h"
#include "mesh/files/text_input.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A number of the file's type and byte order.
inline double load_ply_number(ComponentType type, const char* bytes, bool big_endian) {
  return with_number_type(type, [&]<class Number>(Number number) {
    std::array<char, sizeof(Number)> copy;
    for (std::size_t i = 0; i < sizeof(Number); ++i)
      copy[i] = bytes[big_endian ? sizeof(Number) - 1 - i : i];
    std::memcpy(&number, copy.data(), sizeof(Number));
    return static_cast<double>(number);
  });
}

/// The current place in the body, for messages.
struct PlyPlace {
  std::string_view element;
  std::uint64_t index = 0;
  std::uint64_t count = 0;
};

class BinaryPlyValues {
 public:
  BinaryPlyValues(Input& input, const PlyHeader& header)
      : input_(input), big_endian_(header.format == PlyFormat::kBigEndian) {}

  Input& input() { return input_; }
  bool big_endian() const { return big_endian_; }

  void begin_element(const PlyPlace& place) { place_ = place; }
  void end_element() {}
  double value(ComponentType type) {
    const std::size_t bytes = component_bytes(type);
    if (!input_.ensure(bytes)) refuse_end();
    value_offset_ = input_.offset();
    const double result = load_ply_number(type, input_.unread().data(), big_endian_);
    input_.consume(bytes);
    return result;
  }
  void skip(ComponentType type, std::uint64_t count) {
    if (!input_.skip(count * component_bytes(type))) refuse_end();
  }
  /// Throws kInvalidArgument with the place of the last value(). REQUIRES: begin_element() was
  /// called.
  [[noreturn]] void refuse(std::string_view expected, std::string_view found) const {
    refuse_at(value_offset_, expected, found);
  }
  [[noreturn]] void refuse_at(std::uint64_t offset, std::string_view expected,
                              std::string_view found) const;
  [[noreturn]] void refuse_end() const;
  /// Consumes blanks. Returns whether nothing else follows.
  bool at_end();

 private:
  Input& input_;
  bool big_endian_;
  PlyPlace place_;
  std::uint64_t value_offset_ = 0;
};

class TextPlyValues {
 public:
  TextPlyValues(Input& input, const PlyHeader& header)
      : text_(input, TextRules{}, header.lines + 1) {}

  void begin_element(const PlyPlace& place);
  void end_element();
  double value(ComponentType type);
  /// The text of the last value, until the next call.
  std::string_view word() const { return word_; }
  void skip(ComponentType type, std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) value(type);
  }
  [[noreturn]] void refuse(std::string_view expected, std::string_view found) const;
  bool at_end();

 private:
  TextInput text_;
  std::string_view word_;
  PlyPlace place_;
};

PLAIT_END_NAMESPACE
