// Writes and reads fields that follow each other without gaps: little-endian numbers, and texts,
// each after its length.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "format/byte_order.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

class FieldWriter {
 public:
  template <class T>
  void put(T value) {
    bytes_.resize(bytes_.size() + sizeof(T));
    save(std::span(bytes_), bytes_.size() - sizeof(T), value);
  }
  /// Errors: kInvalidArgument for text that is longer than `most_bytes`, or not printable ASCII.
  void put_text(std::string_view text, std::size_t most_bytes, std::string_view field) {
    if (text.size() > most_bytes || !is_printable(text))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("describe version: {}: expected at most {} printable ASCII "
                              "characters, found {} bytes{}",
                              field, most_bytes, text.size(),
                              is_printable(text) ? "" : ", not all of them printable"));
    put_bytes(text);
  }
  /// Errors: kInvalidArgument for text that is longer than `most_bytes`, or not is_utf8_text().
  void put_utf8(std::string_view text, std::size_t most_bytes, std::string_view field) {
    if (text.size() > most_bytes || !is_utf8_text(text))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("describe version: {}: expected at most {} bytes of UTF-8 without "
                              "control characters, found {} bytes{}",
                              field, most_bytes, text.size(),
                              is_utf8_text(text) ? "" : ", not all of them such text"));
    put_bytes(text);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  void put_bytes(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    const auto bytes = std::as_bytes(std::span(text));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }

  std::vector<std::byte> bytes_;
};

class FieldReader {
 public:
  /// Both arguments must outlive this object. `path` is for messages.
  FieldReader(std::span<const std::byte> bytes, const std::filesystem::path& path)
      : bytes_(bytes), path_(path) {}

  /// Errors: kCorruption if the bytes end too early.
  template <class T>
  T take(std::string_view field) {
    if (bytes_.size() - at_ < sizeof(T)) throw ends_before(field);
    const T value = load<T>(bytes_, at_);
    at_ += sizeof(T);
    return value;
  }
  /// Errors: kCorruption if the bytes end too early, and for text that is longer than `most_bytes`
  /// or not printable ASCII.
  std::string take_text(std::size_t most_bytes, std::string_view field) {
    std::string text = take_bytes(most_bytes, field);
    require(is_printable(text), fmt::format("a character of {}", field), "not printable");
    return text;
  }
  /// The same for text that is is_utf8_text().
  std::string take_utf8(std::size_t most_bytes, std::string_view field) {
    std::string text = take_bytes(most_bytes, field);
    require(is_utf8_text(text), fmt::format("a character of {}", field), "no UTF-8 text");
    return text;
  }
  std::size_t bytes_left() const { return bytes_.size() - at_; }

  /// Throws kCorruption unless `right`.
  template <class Found>
  void require(bool right, std::string_view field, const Found& found) const {
    if (!right)
      throw Error(
          ErrorCode::kCorruption,
          fmt::format("open {}: before byte {} of the description {} is {}, which is out of "
                      "range",
                      path_.native(), at_, field, found));
  }

 private:
  std::string take_bytes(std::size_t most_bytes, std::string_view field) {
    const auto length = take<std::uint32_t>(field);
    require(length <= most_bytes, fmt::format("the length of {}", field), length);
    if (bytes_.size() - at_ < length) throw ends_before(field);
    std::string text(reinterpret_cast<const char*>(bytes_.data()) + at_, length);
    at_ += length;
    return text;
  }
  Error ends_before(std::string_view field) const {
    return {ErrorCode::kCorruption,
            fmt::format("open {}: the description ends at byte {}, before {}", path_.native(),
                        bytes_.size(), field)};
  }

  std::span<const std::byte> bytes_;
  const std::filesystem::path& path_;
  std::size_t at_ = 0;
};

PLAIT_END_NAMESPACE
