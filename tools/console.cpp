#include "console.h"

#include <cerrno>
#include <cstdio>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "interrupt.h"
#include "json_text.h"

namespace plait {
namespace {

std::string one_line(std::string_view text) {
  std::string line(text);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return line;
}

}  // namespace

int exit_status(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::kInvalidArgument:
    case ErrorCode::kNotSupported:
    case ErrorCode::kNotFound:
      return kExitRefused;
    case ErrorCode::kCancelled: {
      const int signal_number = interrupt_signal();
      return signal_number == 0 ? kExitFailed : kExitSignalBase + signal_number;
    }
    default:
      return kExitFailed;
  }
}

int exit_status_with_plan(const Error& error, const std::filesystem::path& plan) {
  switch (error.code()) {
    case ErrorCode::kIo:
    case ErrorCode::kNoSpace:
    case ErrorCode::kOutOfMemory:
    case ErrorCode::kBusy:
      return kExitAgain;
    case ErrorCode::kNotFound: {
      const std::string inside = (std::filesystem::absolute(plan) / "").lexically_normal().native();
      const std::string found = std::filesystem::absolute(error.path()).lexically_normal().native();
      std::error_code ignored;
      if (!error.path().empty() && found.starts_with(inside) && found.size() > inside.size() &&
          std::filesystem::exists(std::filesystem::path(inside) / "plan", ignored))
        return kExitAgain;
      break;
    }
    default:
      break;
  }
  return exit_status(error.code());
}

void print(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size())
    throw system_error("write", "standard output", errno);
}

void flush_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw system_error("write", "standard output", errno == 0 ? EIO : errno);
}

std::string error_line(std::string_view message) { return "plait: " + one_line(message) + "\n"; }

std::string error_object(std::string_view code, std::string_view message) {
  const nlohmann::ordered_json object = {
      {"error", {{"code", code}, {"message", one_line(message)}}}};
  return json_text(object);
}

void report_error(std::string_view code, std::string_view message, bool json) noexcept {
  try {
    std::fputs(error_line(message).c_str(), stderr);
    if (!json) return;
    print(error_object(code, message));
    flush_output();
  } catch (...) {
    // Standard output is closed, or there is no memory. The exit status still reports the error.
  }
}

void report_warning(std::string_view message) noexcept {
  static std::mutex mutex;
  static std::set<std::string, std::less<>> said;
  try {
    const std::scoped_lock lock(mutex);
    if (!said.emplace(message).second) return;
    std::fprintf(stderr, "plait: warning: %s\n", one_line(message).c_str());
  } catch (...) {
  }
}

}  // namespace plait
