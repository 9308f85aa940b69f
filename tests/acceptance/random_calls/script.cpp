#include "acceptance/random_calls/script.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <exception>
#include <random>
#include <sstream>
#include <utility>

#include "acceptance/random_calls/machine.h"

namespace plait::test {
namespace {

/// Names of calls, some of them more often.
constexpr std::array kNames = {"add",    "level",     "remove",    "replace", "sweep",  "sweep",
                               "sweep",  "subdivide", "subdivide", "commit",  "commit", "roll_back",
                               "close",  "drop",      "open",      "open",    "guest",  "leave",
                               "reader", "view",      "release",   "base",    "face",   "text",
                               "digest", "verify",    "recode",    "busy",    "gone",   "visit",
                               "visit",  "writer",    "writer",    "walk",    "walk"};

}  // namespace

Outcomes::Counts& Outcomes::of(const std::string& name) {
  const auto found = std::ranges::find(calls, name, &std::pair<std::string, Counts>::first);
  if (found != calls.end()) return found->second;
  return calls.emplace_back(name, Counts()).second;
}

std::string to_text(const Script& script) {
  std::string text =
      fmt::format("begin {} {} {}", script.begin.backend, script.begin.budget, script.begin.mesh);
  for (const Call& call : script.calls)
    text += fmt::format("; {} {} {} {}", call.name, call.a, call.b, call.c);
  return text;
}

Script script_from(const std::string& text) {
  Script script;
  std::istringstream words(text);
  std::string separated;
  while (std::getline(words, separated, ';')) {
    std::istringstream call(separated);
    Call read;
    call >> read.name >> read.a >> read.b >> read.c;
    if (read.name == "begin")
      script.begin = {read.a, read.b, read.c};
    else if (!read.name.empty())
      script.calls.push_back(std::move(read));
  }
  return script;
}

Script random_script(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto any = [&] { return static_cast<std::uint32_t>(random() % 1000); };
  Script script;
  script.begin = {any(), any(), any()};
  const std::size_t length = 5 + random() % 40;
  for (std::size_t i = 0; i < length; ++i)
    script.calls.push_back({kNames[random() % kNames.size()], any(), any(), any()});
  return script;
}

std::optional<std::string> run_script(const Script& script, Outcomes* outcomes) {
  std::size_t at = 0;
  try {
    Machine machine(script, outcomes);
    for (; at < script.calls.size(); ++at) {
      machine.run(script.calls[at]);
      machine.check();
    }
    return std::nullopt;
  } catch (const std::exception& error) {
    return fmt::format("call {}, {}: {}", at + 1,
                       at < script.calls.size() ? script.calls[at].name : "end", error.what());
  }
}

Script shrunk(Script script) {
  for (std::size_t part = std::max<std::size_t>(script.calls.size() / 2, 1); part > 0;) {
    bool shorter = false;
    for (std::size_t first = 0; first < script.calls.size();) {
      Script without = script;
      const auto from = without.calls.begin() + static_cast<std::ptrdiff_t>(first);
      without.calls.erase(
          from, from + static_cast<std::ptrdiff_t>(std::min(part, script.calls.size() - first)));
      if (run_script(without)) {
        script = std::move(without);
        shorter = true;
      } else {
        first += part;
      }
    }
    if (!shorter) part /= 2;
  }
  return script;
}

}  // namespace plait::test
