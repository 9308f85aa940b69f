// Little-endian fields at fixed offsets of a byte buffer.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "plait/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

static_assert(std::endian::native == std::endian::little,
              "level files are mapped and read without conversion, and they are little-endian");

template <class T>
T load(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.subspan(offset, sizeof(T)).data(), sizeof(T));
  return value;
}

template <class T>
void save(std::span<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.subspan(offset, sizeof(T)).data(), &value, sizeof(T));
}

/// Text padded with zero bytes to `size`; at least one is needed. Returns false if it is too long.
inline bool save_text(std::span<std::byte> bytes, std::size_t offset, std::size_t size,
                      std::string_view text) {
  if (text.size() >= size) return false;
  std::memcpy(bytes.subspan(offset, size).data(), text.data(), text.size());
  return true;
}

inline std::string load_text(std::span<const std::byte> bytes, std::size_t offset,
                             std::size_t size) {
  const auto* text = reinterpret_cast<const char*>(bytes.subspan(offset, size).data());
  return std::string(text, strnlen(text, size));
}

PLAIT_END_NAMESPACE
