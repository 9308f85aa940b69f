// A measurement's main(): options by CLI11, errors in one line.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

namespace plait::bench {

/// declare(app) adds the options, run() measures and returns the exit status.
template <class Declare, class Run>
int run_program(const char* name, const char* description, int count, char** words, Declare declare,
                Run run) {
  try {
    CLI::App app(description);
    declare(app);
    try {
      app.parse(count, words);
    } catch (const CLI::ParseError& error) {
      return app.exit(error);
    }
    return run();
  } catch (const std::exception& error) {
    std::fputs(fmt::format("{}: {}\n", name, error.what()).c_str(), stderr);
    return 1;
  } catch (...) {
    return 1;
  }
}

}  // namespace plait::bench
