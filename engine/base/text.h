// base/text.h: texts of messages, files and options: counts of bytes, UTF-8, printable lines,
// names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_NAMESPACE

/// "512 bytes", "1.50 KiB", "2.33 GiB". Pinned by tests/tools/arguments_test.cpp.
std::string format_bytes(std::uint64_t bytes);
/// The exact number with the largest unit that divides it: "1MiB", "65537". The program accepts
/// this text as a size.
std::string size_text(std::uint64_t bytes);

/// The extension of `path` in lower case: ".ply" of "BUNNY.PLY".
std::string lower_extension(const std::filesystem::path& path);

/// At most the first 100 characters, with a question mark for each that is not printable ASCII: a
/// message is one line, and a terminal may take other bytes for commands.
std::string text_for_message(std::string_view text);

// Names of the values of an enumeration, and one message for a name that is none of them: "unknown
// executor 'x', expected auto, fused, sweep, transparent".

/// The names with commas between them.
std::string join_names(std::span<const std::string_view> names);
/// The error for a name that is none of `names`. `what` says of what: "executor".
Error unknown_name(std::string_view what, std::string_view name,
                   std::span<const std::string_view> names);

/// A table of names, without heap memory.
template <class Value, std::size_t kCount>
class NameTable {
 public:
  constexpr NameTable(std::string_view what,
                      const std::pair<Value, std::string_view> (&entries)[kCount])
      : what_(what) {
    for (std::size_t i = 0; i < kCount; ++i) {
      values_[i] = entries[i].first;
      names_[i] = entries[i].second;
    }
  }

  constexpr std::string_view name_of(Value value) const noexcept {
    for (std::size_t i = 0; i < kCount; ++i)
      if (values_[i] == value) return names_[i];
    return "unknown";
  }
  /// Errors: kInvalidArgument; the message lists the names.
  Value find(std::string_view name) const {
    for (std::size_t i = 0; i < kCount; ++i)
      if (names_[i] == name) return values_[i];
    throw unknown_name(what_, name, names_);
  }
  std::string names() const { return join_names(names_); }

 private:
  std::string_view what_;
  std::array<Value, kCount> values_{};
  std::array<std::string_view, kCount> names_{};
};

PLAIT_END_NAMESPACE

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Texts of people: which bytes are well-formed UTF-8.

/// Whether `text` is well-formed UTF-8 and has no control character but tab and line feed. Source:
/// The Unicode Standard, version 15.0 (2022), table 3-7. Pinned by tests/engine/base/text_test.cpp.
bool is_utf8_text(std::string_view text) noexcept;

PLAIT_END_NAMESPACE
