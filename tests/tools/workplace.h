// tests/tools/workplace.h: a directory in which a test runs commands of the program.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/program.h"

namespace plait::test {

using Words = std::vector<std::string>;

struct Workplace {
  TemporaryDirectory directory;

  explicit Workplace(Medium medium = Medium::kDisk) : directory(medium) {}
  std::filesystem::path path(const std::string& name) const { return directory.path() / name; }
  bool has(const std::string& name) const { return std::filesystem::exists(path(name)); }
  Words names() const { return names_in(directory.path()); }

  /// Runs the program with `words` and `more` words.
  Outcome plait(Words words, const Words& more = {}) const {
    words.insert(words.end(), more.begin(), more.end());
    return run(directory.path(), std::move(words));
  }
  /// The same, of a command that must succeed.
  Outcome succeed(const Words& words, const Words& more = {}) const {
    Outcome outcome = plait(words, more);
    CAPTURE(words, more, outcome.errors);
    REQUIRE(outcome.status == 0);
    return outcome;
  }
  /// What it reports with --json.
  nlohmann::json report(const Words& words) const { return succeed(words, {"--json"}).json(); }
  std::string digest(const std::string& store) const {
    return succeed({"digest", store}).last_line();
  }
};

}  // namespace plait::test
