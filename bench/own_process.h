// Runs work in a child process, so that the peak of memory is that of this work alone.
#pragma once

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/error.h"

namespace plait::bench {

/// Runs `work` in a forked child and returns its result. An error of the child is thrown here as
/// kIo with the child's message; kBudget and kNotSupported keep their codes. REQUIRES: this process
/// has no other thread, and none of TBB, because a child has only the thread that forked.
template <class Work>
nlohmann::json in_own_process(Work work) {
  int ends[2];
  if (::pipe(ends) != 0) throw system_error("make", "pipe", errno);
  const pid_t child = ::fork();
  if (child < 0) throw system_error("make", "process", errno);
  if (child == 0) {
    ::close(ends[0]);
    nlohmann::json answer;
    try {
      answer = {{"result", work()}};
    } catch (const Error& error) {
      answer = {{"error", error.what()}, {"code", static_cast<int>(error.code())}};
    } catch (const std::exception& error) {
      answer = {{"error", error.what()}, {"code", static_cast<int>(ErrorCode::kIo)}};
    }
    const std::string text = answer.dump();
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t count = ::write(ends[1], text.data() + sent, text.size() - sent);
      if (count < 0) ::_exit(1);
      sent += static_cast<std::size_t>(count);
    }
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t count; (count = ::read(ends[0], part, sizeof part)) > 0;)
    text.append(part, static_cast<std::size_t>(count));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (text.empty()) throw Error(ErrorCode::kIo, "the process of a run ended without a result");
  const nlohmann::json answer = nlohmann::json::parse(text);
  if (answer.contains("error"))
    throw Error(static_cast<ErrorCode>(answer["code"].get<int>()), answer["error"]);
  return answer["result"];
}

/// VmHWM or VmRSS of /proc/self/status in bytes; 0 if the file has no such line.
inline std::uint64_t memory_status(const std::string& name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kibibytes = 0;
  while (status >> word)
    if (word == name + ":") {
      status >> kibibytes;
      break;
    }
  return kibibytes * 1024;
}

/// Measures by how much the resident set grows from construction to its peak.
class PeakMemory {
 public:
  /// First returns free heap pages to the system, so that pages which the work takes are counted.
  PeakMemory() {
    ::malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak counts from now on
    before_ = memory_status("VmRSS");
  }
  std::uint64_t bytes() const {
    const std::uint64_t peak = memory_status("VmHWM");
    return peak > before_ ? peak - before_ : 0;
  }

 private:
  std::uint64_t before_;
};

}  // namespace plait::bench
