// tools/arguments.h: options that several commands have, with the same words in each.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "argument_text.h"
#include "command.h"
#include "plait/attribute.h"
#include "plait/error.h"

namespace plait {

/// A size in bytes, parsed by parse_size. `value` must outlive parsing.
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
/// --plugin FILE, for commands that open or make a store. The program loads the plug-ins before it
/// runs a command that has this option.
CLI::Option* add_plugin_option(CLI::App& command, CommandContext& context);
/// --compress TEXT, which may be repeated (plait/backends/compression.h).
CLI::Option* add_compress_option(CLI::App& command, std::vector<std::string>& texts);
/// The pipelines that the texts of --compress name. Errors: as Compression::add().
std::function<std::string(const AttributeSchema&)> pipelines_of(
    const std::vector<std::string>& texts);
/// The text about --compress for --help.
std::string compression_help();
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
