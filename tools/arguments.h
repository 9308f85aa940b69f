// tools/arguments.h: options that several commands have, with the same words in each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "argument_text.h"
#include "command.h"
#include "command_line/command_line.h"
#include "plait/attribute.h"
#include "plait/options.h"

namespace plait {

/// A size in bytes, parsed by parse_size. `value` must outlive parsing.
Option* add_size_option(CommandLine& command, const std::string& name, std::uint64_t& value,
                        const std::string& description);
/// A whole number from `first` to `last`, parsed by parse_whole_number.
template <class Number>
Option* add_whole_option(CommandLine& command, const std::string& name, Number& value,
                         std::uint64_t first, std::uint64_t last, const std::string& description);
/// --threads N, 0 to 1024. `threads` becomes thread_count(N), with 0 as the default.
Option* add_threads_option(CommandLine& command, int& threads, const std::string& description);
/// --level K, 0 to kMaxLevel. A command uses the finest level if the option is not given (-1).
Option* add_level_option(CommandLine& command, int& level, const std::string& description);
/// A positional argument that names the output. "-" is refused, because commands write no output to
/// standard output.
Option* add_output_option(CommandLine& command, const std::string& name,
                          std::filesystem::path& path, const std::string& description);
/// --plugin FILE, for commands that open or make a store. The program loads the plug-ins before it
/// runs a command that has this option.
Option* add_plugin_option(CommandLine& command, CommandContext& context);
/// The text about --compress for --help.
std::string compression_help();
/// The text about --max-error for --help.
std::string max_error_help();
Option* add_json_option(CommandLine& command, CommandContext& context);
/// The text for --help: a line for each backend of the registry.
std::string backend_help(const BackendRegistry& backends);

template <class Number>
Option* add_whole_option(CommandLine& command, const std::string& name, Number& value,
                         std::uint64_t first, std::uint64_t last, const std::string& description) {
  return command
      .add_parsed_option(
          name,
          [&value, first, last](const std::string& text) {
            value = static_cast<Number>(parse_whole_number(text, first, last));
          },
          description)
      ->type_name("N");
}

}  // namespace plait
