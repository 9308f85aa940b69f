// tests/fuzz/input_bytes.h: splits the input of a target into a few numbers and the rest.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

namespace plait::fuzz {

class InputBytes {
 public:
  InputBytes(const std::uint8_t* data, std::size_t size)
      : rest_(std::as_bytes(std::span(data, size))) {}

  /// The next number, little-endian. Bytes that the input does not have are zero.
  template <class Number>
  Number take() {
    Number number{};
    const std::size_t bytes = std::min(sizeof(Number), rest_.size());
    if (bytes > 0) std::memcpy(&number, rest_.data(), bytes);
    rest_ = rest_.subspan(bytes);
    return number;
  }

  /// A number below `count`.
  std::size_t take_below(std::size_t count) { return take<std::uint8_t>() % count; }

  std::span<const std::byte> rest() const { return rest_; }

 private:
  std::span<const std::byte> rest_;
};

/// Memory of exactly `size` bytes, so that the address sanitizer detects access to the first byte
/// after it. Unlike a vector, it has an address even if it is empty.
class ExactBytes {
 public:
  explicit ExactBytes(std::size_t size)
      : bytes_(std::make_unique<std::byte[]>(size)), size_(size) {}
  explicit ExactBytes(std::span<const std::byte> content) : ExactBytes(content.size()) {
    std::copy(content.begin(), content.end(), bytes_.get());
  }

  std::span<std::byte> span() { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t size_;
};

}  // namespace plait::fuzz
