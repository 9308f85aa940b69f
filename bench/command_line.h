// What a measurement is from outside: options by CLI11, errors in one line, figures to a file.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "plait/error.h"

namespace plait::bench {

/// To `path` unless that is empty. Errors: kIo.
inline void write_json(const std::string& path, const nlohmann::ordered_json& figures) {
  if (path.empty()) return;
  std::ofstream file(path);
  file << figures.dump(2) << '\n';
  if (!file.flush())
    throw Error(ErrorCode::kIo, fmt::format("write {}: it cannot be written", path));
}

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
