// option_text.h: values of options, from the text of a command line or of a job's option.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Bytes from "65536", "64K", "64KiB", "1.5 GiB": K, M, G and T are powers of 1024, with or without
/// "iB" or "B", in either case. Errors: kInvalidArgument for anything else, for a size that is not
/// a whole number of bytes, and for a size that does not fit 64 bits.
/// Pinned by tests/tools/arguments_test.cpp.
std::uint64_t parse_size(std::string_view text);

/// A whole number from `first` to `last`. Errors: kInvalidArgument for anything else, such as "-1"
/// if `first` is 0, or a number that does not fit 64 bits.
std::uint64_t parse_whole_number(std::string_view text, std::uint64_t first, std::uint64_t last);

/// A number from `first` to `last`. Errors: kInvalidArgument for anything else.
double parse_number(std::string_view text, double first, double last);

/// A length, or a part of a diagonal in percent.
struct RelativeLength {
  double number = 0;
  bool is_percent = false;

  double of(double diagonal) const { return is_percent ? number / 100 * diagonal : number; }
};
/// "0.5" or "0.05%". Errors: kInvalidArgument for anything else, and for a number below 0.
RelativeLength parse_relative_length(std::string_view text);

/// Throws kInvalidArgument unless `path` ends in `extension`, in upper or lower case. `extension`
/// is in lower case. The message begins with `verb`.
void require_extension(std::string_view verb, const std::filesystem::path& path,
                       std::string_view extension);

PLAIT_END_NAMESPACE
