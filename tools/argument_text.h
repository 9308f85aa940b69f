// tools/argument_text.h: reads values from the text of the command line, and writes quantities and
// words of a command line as text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "option_text.h"

namespace plait {

/// "26,016".
std::string format_count(std::uint64_t count);

/// A word of a command that a user can paste into a POSIX shell: `word` itself, or in quotes if it
/// is empty or has a character that a shell could treat in a special way.
/// Pinned by tests/tools/arguments_test.cpp.
std::string shell_word(std::string_view word);

/// The command that this process runs, as shell words, with "plait" as the program.
std::string command_text();

}  // namespace plait
