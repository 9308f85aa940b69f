// base/name_table.h: the names of the values of an enumeration, and one message for a name that is
// none of them: "unknown executor 'x', expected auto, fused, sweep, transparent".
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_NAMESPACE

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
