// The command line of a measurement: options, each with its help; errors in one line; exit
// status 0 done, 1 failed, 2 bad usage; a temporary directory for its files.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "command_line/command_line.h"
#include "micro/work_directory.h"
#include "plait/error.h"

namespace plait::bench {

// Options of several measurements, with the same words in each.
inline void add_mesh_option(CommandLine& app, std::string& mesh, const char* otherwise) {
  app.add_option("--mesh", mesh, fmt::format("PLY, OBJ or OFF; default: {}", otherwise));
}
inline Option* add_number_option(CommandLine& app, const char* name, int& value, int first,
                                 int last, const std::string& description) {
  return app.add_option(name, value, description)->range(first, last)->capture_default_str();
}
/// Of a surface that is made from an octahedron.
inline void add_surface_options(CommandLine& app, int& refinements, int& level) {
  add_number_option(app, "--refinements", refinements, 0, 9,
                    "How often an octahedron is refined to be the base mesh");
  add_number_option(app, "--level", level, 1, 10, "The finest level");
}
inline void add_backends_option(CommandLine& app, std::vector<std::string>& backends) {
  app.add_option("--backend", backends, "Backends, several with commas")->delimiter(',');
}
inline void add_threads_option(CommandLine& app, std::vector<int>& threads) {
  app.add_option("--threads", threads, "Numbers of threads, several with commas")
      ->delimiter(',')
      ->range(1, 64);
}
inline void add_runs_option(CommandLine& app, int& runs) {
  add_number_option(app, "--runs", runs, 1, 1000, "Turns; the figures are medians of all turns");
}
inline void add_directory_option(CommandLine& app, std::string& directory) {
  app.add_option("--directory", directory, "Where to make temporary files: on the disk to measure")
      ->capture_default_str();
}

/// declare(app) adds the options. run() measures and returns the exit status. `directory` is where
/// the measurement makes files, as for in_work_directory(); nullptr if it makes none.
template <class Declare, class Run>
int run_program(const char* name, const char* description, int count, char** words, Declare declare,
                Run run, std::string* directory = nullptr) {
  const auto fail = [&](const std::string& why, int status) {
    std::fputs(fmt::format("{}: {}\n", name, why).c_str(), stderr);
    return status;
  };
  const auto run_and_report = [&] {
    try {
      return run();
    } catch (const std::exception& error) {
      return fail(error.what(), 1);
    }
  };
  try {
    CommandLine app(description, name);
    declare(app);
    if (app.parse(count, words) == CommandLine::Outcome::kAnswered) {
      std::fputs(app.answer().c_str(), stdout);
      return 0;
    }
    return directory != nullptr ? in_work_directory(*directory, run_and_report) : run_and_report();
  } catch (const UsageError& error) {
    return fail(fmt::format("{} (see --help)", error.what()), 2);
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  } catch (...) {
    return 1;
  }
}

}  // namespace plait::bench
