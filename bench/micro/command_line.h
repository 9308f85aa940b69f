// bench/micro/command_line.h: the command line of a measurement: options, each with its help;
// errors in one line; exit status 0 done, 1 failed, 2 bad usage; a temporary directory for its
// files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "command_line/command_line.h"

namespace plait::bench {

/// What the options of measurements set. A program has some of the options, and defaults of its
/// own; the help texts in command_line.cpp say what each option means.
struct Settings {
  std::string mesh = {}, other = {}, only = {}, directory = ".";
  std::vector<std::string> backends = {}, layouts = {"hilbert", "given"};
  std::vector<int> threads = {1, 2};
  int refinements = 5, level = 5, first = 3, last = 6, runs = 5;
  int reads = 20000, queries = 2000, samples = 1000000, points = 32;
  int blocks = 32, block_kib = 1024, budget_mib = 0;

  /// Where a measurement makes its store.
  std::filesystem::path store() const {
    return std::filesystem::path(directory) / "plait-bench.plait";
  }
  std::uint64_t block_bytes() const { return static_cast<std::uint64_t>(block_kib) << 10; }
  std::uint64_t budget_bytes() const {
    return budget_mib == 0 ? std::uint64_t{1} << 34 : static_cast<std::uint64_t>(budget_mib) << 20;
  }
};

class Program {
 public:
  /// `options`: those of the table in command_line.cpp that the program has.
  Program(const char* name, const char* description, Settings defaults = {},
          std::initializer_list<const char*> options = {});

  /// For options of one measurement.
  CommandLine& options() { return options_; }

  /// With the option --directory, Settings::directory is a new directory in the one that the option
  /// named, which is removed in the end. On SIGINT, SIGTERM or SIGHUP, say_progress() throws, and
  /// the exit status is 128 plus the number of the signal.
  int run(int count, char** words, void (*measure)(const Settings&));
  /// `measure` returns the exit status, which this returns too.
  int run(int count, char** words, const std::function<int()>& measure);

 private:
  int fail(const std::string& why, int status) const;

  const char* name_;
  Settings settings_;
  CommandLine options_;
};

/// Prints a line to standard error if it is a terminal. Called before each step of a measurement.
/// Errors: kCancelled after a signal.
void say_progress(const std::string& text);

}  // namespace plait::bench
