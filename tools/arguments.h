// tools/arguments.h: values of the command line from text, and quantities into text.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <string_view>

#include "command.h"

namespace plait {

/// Bytes from "65536", "64K", "64KiB", "1.5 GiB": K, M and G are powers of 1024, with or without
/// "iB" or "B", in either case. Errors: kInvalidArgument for anything else, for what is no whole
/// number of bytes, and for what does not fit into 64 bits.
/// Pinned by tests/tools/arguments_test.cpp.
std::uint64_t parse_size(std::string_view text);

struct PictureSize {
  int width = 0, height = 0;  ///< pixels, 1 to 8192
};
/// "1600x1200". Errors: kInvalidArgument.
PictureSize parse_picture_size(std::string_view text);

struct ViewAngles {
  double azimuth = 0, elevation = 0;  ///< degrees
};
/// "30,20": azimuth -360 to 360, elevation -90 to 90. Errors: kInvalidArgument.
ViewAngles parse_view(std::string_view text);

/// "512 bytes", "1.50 KiB", "2.33 GiB".
std::string format_bytes(std::uint64_t bytes);
/// The shortest text that parse_size takes back: "1MiB", "65537".
std::string size_text(std::uint64_t bytes);
/// "26,016".
std::string format_count(std::uint64_t count);

/// Options that several commands share, worded the same everywhere. `value` must outlive parsing.
CLI::Option* add_size_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                             const std::string& description);
CLI::Option* add_json_option(CLI::App& command, CommandContext& context);
/// A line for each backend of the registry, for --help.
std::string backend_help(const BackendRegistry& backends);
/// hardware_concurrency, or 1 where that is not known.
int default_thread_count();

}  // namespace plait
