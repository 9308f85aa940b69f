// tools/console.h: the program's messages and exit statuses.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "plait/error.h"

namespace plait {

/// Exit statuses (documented in `plait --help`).
constexpr int kExitDone = 0;
constexpr int kExitFailed = 1;
constexpr int kExitRefused = 2;
constexpr int kExitAgain = 3;         ///< commands of a plan: the same command may end well later
constexpr int kExitSignalBase = 128;  ///< plus the number of the signal that cancelled the work

/// kExitRefused for bad usage and refused input (kInvalidArgument, kNotSupported, kNotFound), 128
/// plus the signal for a cancelled run, kExitFailed for all other errors.
int exit_status(ErrorCode code) noexcept;
/// For commands that a scheduler starts, with the plan that they work on: kExitAgain if the reason
/// may pass by itself (the disk, its room, memory, another process, or a file in the plan that
/// another machine replaces or does not show yet), otherwise exit_status().
int exit_status_with_plan(const Error& error, const std::filesystem::path& plan);

/// Writes to standard output. Errors: kIo or kNoSpace (a closed pipe, a full disk).
void print(std::string_view text);
/// Writes all buffered text to standard output. Errors: as print().
void flush_output();

/// "plait: MESSAGE" and a newline, always one line.
std::string error_line(std::string_view message);
/// {"error": {"code", "message"}} and a newline.
std::string error_object(std::string_view code, std::string_view message);
/// error_line() on standard error; with `json` also error_object() on standard output. Never
/// throws.
void report_error(std::string_view code, std::string_view message, bool json) noexcept;
/// "plait: warning: MESSAGE" on standard error, once for each message.
void report_warning(std::string_view message) noexcept;

}  // namespace plait
