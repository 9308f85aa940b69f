// paper/machine_text.h: on what, when and by which command a report was made.
#pragma once

#include <filesystem>
#include <string>

namespace plait::paper {

/// "2 x Intel(R) Xeon(R), Linux 6.18.1, ext4 on vda".
std::string machine_text(const std::filesystem::path& directory);
/// "2026-11-23", in UTC.
std::string date_text();
/// The command line of this process, with quotes where a shell needs them; the program is "plait".
std::string command_text();

}  // namespace plait::paper
