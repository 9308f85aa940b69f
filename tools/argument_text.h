// tools/argument_text.h: reads values from the text of the command line, and writes quantities and
// words of a command line as text.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "option_text.h"

namespace plait {

/// A distance of 0 or more. Errors: kInvalidArgument for anything else.
double parse_tolerance(std::string_view text);

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

/// A word of a command that a user can paste into a POSIX shell: `word` itself, or in quotes if it
/// is empty or has a character that a shell could treat in a special way.
/// Pinned by tests/tools/arguments_test.cpp.
std::string shell_word(std::string_view word);

/// The command that this process runs, as shell words, with "plait" as the program.
std::string command_text();

}  // namespace plait
