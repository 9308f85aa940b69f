// bench/micro/command_line.h: the command line of a measurement: options, each with its help;
// errors in one line; exit status 0 done, 1 failed, 2 bad usage; a temporary directory for its
// files.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "command_line/command_line.h"
#include "micro/work_directory.h"
#include "plait/error.h"

namespace plait::bench {

/// A measurement with its options. Those of several measurements have the same words in each.
class Program {
 public:
  Program(const char* name, const char* description) : name_(name), options_(description, name) {}

  Program& number(const char* option, int& value, int first, int last, const std::string& help) {
    options_.add_option(option, value, help)->range(first, last)->capture_default_str();
    return *this;
  }
  Program& mesh(std::string& mesh, const char* otherwise) {
    options_.add_option("--mesh", mesh, std::string("PLY, OBJ or OFF; default: ") + otherwise);
    return *this;
  }
  /// Of a surface that is made from an octahedron.
  Program& surface(int& refinements, int& level) {
    return number("--refinements", refinements, 0, 9,
                  "How often an octahedron is refined to be the base mesh")
        .number("--level", level, 1, 10, "The finest level");
  }
  Program& levels(int& first, int& last) {
    return number("--first", first, 1, 12, "The first level measured")
        .number("--last", last, 1, 12, "The last level measured");
  }
  Program& backends(std::vector<std::string>& backends) {
    options_.add_option("--backend", backends, "Backends, several with commas")->delimiter(',');
    return *this;
  }
  Program& threads(std::vector<int>& threads) {
    options_.add_option("--threads", threads, "Numbers of threads, several with commas")
        ->delimiter(',')
        ->range(1, 64);
    return *this;
  }
  Program& runs(int& runs) {
    return number("--runs", runs, 1, 1000, "Turns; the figures are medians of all turns");
  }
  /// Where the measurement makes files, as for in_work_directory(). Without it, it makes none.
  Program& directory(std::string& directory) {
    options_
        .add_option("--directory", directory,
                    "Where to make temporary files: on the disk to measure")
        ->capture_default_str();
    directory_ = &directory;
    return *this;
  }
  /// For options of one measurement.
  CommandLine& options() { return options_; }

  /// `measure` returns the exit status, which this returns too.
  int run(int count, char** words, const std::function<int()>& measure) try {
    if (options_.parse(count, words) == CommandLine::Outcome::kAnswered) {
      std::fputs(options_.answer().c_str(), stdout);
      return 0;
    }
    const auto measure_and_report = [&] {
      try {
        return measure();
      } catch (const std::exception& error) {
        return fail(error.what(), 1);
      }
    };
    return directory_ == nullptr ? measure_and_report()
                                 : in_work_directory(*directory_, measure_and_report);
  } catch (const UsageError& error) {
    return fail(fmt::format("{} (see --help)", error.what()), 2);
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  } catch (...) {
    return 1;
  }

 private:
  int fail(const std::string& why, int status) const {
    std::fputs(fmt::format("{}: {}\n", name_, why).c_str(), stderr);
    return status;
  }

  const char* name_;
  CommandLine options_;
  std::string* directory_ = nullptr;
};

}  // namespace plait::bench
