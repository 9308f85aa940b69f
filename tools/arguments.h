// tools/arguments.h: parses values of the command line, and formats quantities as text.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "command.h"
#include "plait/byte_text.h"
#include "plait/error.h"

namespace plait {

/// Bytes from "65536", "64K", "64KiB", "1.5 GiB": K, M, G and T are powers of 1024, with or without
/// "iB" or "B", in either case. Errors: kInvalidArgument for anything else, for a size that is not
/// a whole number of bytes, and for a size that does not fit 64 bits.
/// Pinned by tests/tools/arguments_test.cpp.
std::uint64_t parse_size(std::string_view text);

/// A whole number from `first` to `last`. Errors: kInvalidArgument for anything else, such as "-1"
/// if `first` is 0, or a number that does not fit 64 bits.
std::uint64_t parse_whole_number(std::string_view text, std::uint64_t first, std::uint64_t last);

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

/// The extension of `path` in lower case: ".ply" of "BUNNY.PLY".
std::string lower_extension(const std::filesystem::path& path);
/// Throws kInvalidArgument unless `path` ends in `extension`, in upper or lower case. `extension`
/// is in lower case. The message begins with `verb`.
void require_extension(std::string_view verb, const std::filesystem::path& path,
                       std::string_view extension);

/// "26,016".
std::string format_count(std::uint64_t count);

/// Options of several commands, with the same words in each. `value` must outlive parsing.
CLI::Option* add_size_option(CLI::App& command, const std::string& name, std::uint64_t& value,
                             const std::string& description);
/// The same for a value that stays empty if the option is not given.
CLI::Option* add_size_option(CLI::App& command, const std::string& name,
                             std::optional<std::uint64_t>& value, const std::string& description);
/// A whole number from `first` to `last`, parsed by parse_whole_number.
template <class Number>
CLI::Option* add_whole_option(CLI::App& command, const std::string& name, Number& value,
                              std::uint64_t first, std::uint64_t last,
                              const std::string& description);
/// --threads N, 1 to 1024.
CLI::Option* add_threads_option(CLI::App& command, int& threads, const std::string& description);
/// --level K, 0 to kMaxLevel. A command uses the finest level if the option is not given (-1).
CLI::Option* add_level_option(CLI::App& command, int& level, const std::string& description);
/// A positional argument that names the output. "-" is refused, because commands write no output to
/// standard output.
CLI::Option* add_output_option(CLI::App& command, const std::string& name,
                               std::filesystem::path& path, const std::string& description);
CLI::Option* add_json_option(CLI::App& command, CommandContext& context);
/// The text for --help: a line for each backend of the registry.
std::string backend_help(const BackendRegistry& backends);
/// hardware_concurrency, or 1 if that is unknown.
int default_thread_count();

/// An option whose text goes to `parse`. Errors of `parse` become usage errors that name the
/// option.
template <class Parse>
CLI::Option* add_parsed_option(CLI::App& command, const std::string& name, Parse parse,
                               const std::string& description) {
  return command.add_option_function<std::string>(
      name,
      [name, parse](const std::string& text) {
        try {
          parse(text);
        } catch (const Error& error) {
          throw CLI::ValidationError(name, error.what());
        }
      },
      description);
}

template <class Number>
CLI::Option* add_whole_option(CLI::App& command, const std::string& name, Number& value,
                              std::uint64_t first, std::uint64_t last,
                              const std::string& description) {
  return add_parsed_option(
             command, name,
             [&value, first, last](const std::string& text) {
               value = static_cast<Number>(parse_whole_number(text, first, last));
             },
             description)
      ->type_name("N");
}

}  // namespace plait
