// Random orders of public calls on one store, its readers, views and second opens, against a model
// of the bytes of each attribute and level. Each call must give what the model says, or the error
// that the state of the store demands.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plait::test {

/// One call, and three numbers that choose what it is given.
struct Call {
  std::string name;
  std::uint32_t a = 0, b = 0, c = 0;
};

/// How a script begins: the backend and the pipeline of its store, and its budget.
struct Beginnings {
  std::uint32_t backend = 0, budget = 0, mesh = 0;
};

struct Script {
  Beginnings begin;
  std::vector<Call> calls;
};

/// A script on one line: "begin 2 0 1; sweep 0 3 1; commit 0 0 0", and back.
std::string to_text(const Script& script);
Script script_from(const std::string& text);

Script random_script(std::uint64_t seed);

/// Runs the script. Returns what was wrong, with the number of the call; nothing if all was right.
/// `runs` counts how often each call succeeded and was refused, by name.
struct Outcomes;
std::optional<std::string> run_script(const Script& script, Outcomes* outcomes = nullptr);

/// The shortest script that still fails, of those that come from this one by leaving out calls.
Script shrunk(Script script);

/// How often calls of a name gave a result, and an error.
struct Outcomes {
  struct Counts {
    std::uint64_t done = 0, refused = 0;
  };
  std::vector<std::pair<std::string, Counts>> calls;
  Counts& of(const std::string& name);
};

}  // namespace plait::test
