// tests/tools/program.h: runs the program as a child process and collects its output.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "support/file_bytes.h"
#include "support/temporary_directory.h"

namespace plait::test {

struct Outcome {
  int status = -1;  ///< exit status, or 1000 + the signal that ended the process
  std::string output, errors;

  /// Parses all of standard output as one JSON object. Throws if it is anything else.
  nlohmann::json json() const { return nlohmann::json::parse(output); }
  /// Lines of `errors`.
  std::size_t error_lines() const {
    return static_cast<std::size_t>(std::count(errors.begin(), errors.end(), '\n'));
  }
  std::string last_line() const {
    const std::size_t end = output.find_last_not_of('\n');
    if (end == std::string::npos) return {};
    const std::size_t start = output.rfind('\n', end);
    return output.substr(start == std::string::npos ? 0 : start + 1,
                         end - (start == std::string::npos ? std::string::npos : start));
  }
};

/// A process of PLAIT_PROGRAM with `directory` as its working directory. Standard output goes to a
/// temporary file, unless the caller names another file. With `address_space_bytes`, it has no more
/// (RLIMIT_AS); a limit of the calling process would be one of the whole test, too.
class Program {
 public:
  Program(const std::filesystem::path& directory, std::vector<std::string> arguments,
          const std::filesystem::path& output_path = {}, std::uint64_t address_space_bytes = 0)
      : output_path_(output_path.empty() ? scratch_.path() / "output" : output_path),
        keeps_output_(output_path.empty()) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, output_path_.c_str(), O_WRONLY | O_CREAT, 0644);
    posix_spawn_file_actions_addopen(&actions, 2, (scratch_.path() / "errors").c_str(),
                                     O_WRONLY | O_CREAT, 0644);
    posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
    arguments.insert(arguments.begin(), PLAIT_PROGRAM);
    std::string executable = PLAIT_PROGRAM;
    if (address_space_bytes > 0) {
      executable = "/bin/sh";
      const std::string limited =
          "ulimit -v " + std::to_string(address_space_bytes / 1024) + "; exec \"$0\" \"$@\"";
      arguments.insert(arguments.begin(), {"sh", "-c", limited});
    }
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const int error =
        ::posix_spawn(&process_, executable.c_str(), &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::system_error(error, std::generic_category(), executable);
  }

  pid_t process() const { return process_; }

  bool has_ended() const {
    siginfo_t ended{};
    ::waitid(P_PID, static_cast<id_t>(process_), &ended, WEXITED | WNOHANG | WNOWAIT);
    return ended.si_pid != 0;
  }
  /// Waits for the condition. False if the program ends before, or after ten minutes: a busy
  /// machine may take that long, and a test is ended soon after.
  bool runs_until(const std::function<bool()>& condition) const {
    for (int turn = 0; turn < 60'000; ++turn) {
      if (condition()) return true;
      if (has_ended()) return condition();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  /// Waits until the program handles the signal itself. Before, the signal would just end it.
  bool runs_until_it_handles(int signal_number) const {
    return runs_until([&] {
      std::ifstream status("/proc/" + std::to_string(process_) + "/status");
      for (std::string line; std::getline(status, line);)
        if (line.starts_with("SigCgt:"))
          return (std::stoull(line.substr(7), nullptr, 16) >> (signal_number - 1) & 1) != 0;
      return false;
    });
  }

  Outcome wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0)
      if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waitpid");
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status),
            keeps_output_ ? content_of(output_path_) : std::string(),
            content_of(scratch_.path() / "errors")};
  }

 private:
  TemporaryDirectory scratch_{Medium::kMemory};
  std::filesystem::path output_path_;
  bool keeps_output_;
  pid_t process_ = -1;
};

/// Runs the program in `directory` to its end.
inline Outcome run(const std::filesystem::path& directory, std::vector<std::string> arguments) {
  return Program(directory, std::move(arguments)).wait();
}

/// Names in a directory, sorted.
inline std::vector<std::string> names_in(const std::filesystem::path& directory) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Runs the program, and sends it the signal as soon as the condition holds. A busy machine may let
/// the program end before the signal comes: then what it made is removed, and it runs again, five
/// times at most.
inline Outcome run_until(const std::filesystem::path& directory,
                         const std::vector<std::string>& arguments, int signal_number,
                         const std::function<bool()>& condition) {
  const std::vector<std::string> before = names_in(directory);
  for (int tries = 5;; --tries) {
    Program program(directory, arguments);
    program.runs_until(condition);
    ::kill(program.process(), signal_number);
    Outcome outcome = program.wait();
    if (outcome.status != 0 || tries == 1) return outcome;
    for (const std::string& name : names_in(directory))
      if (!std::binary_search(before.begin(), before.end(), name))
        std::filesystem::remove_all(directory / name);
  }
}

}  // namespace plait::test
