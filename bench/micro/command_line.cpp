#include "micro/command_line.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <string_view>
#include <utility>

#include "instrument/scratch_directory.h"
#include "plait/error.h"

namespace plait::bench {
namespace {

constexpr struct {
  const char* name;
  int Settings::*value;
  int first, last;
  const char* help;
} kNumbers[] = {
    {"--refinements", &Settings::refinements, 0, 9,
     "How often an octahedron is refined to be the base mesh"},
    {"--level", &Settings::level, 1, 12, "The finest level"},
    {"--first", &Settings::first, 1, 12, "The first level measured"},
    {"--last", &Settings::last, 1, 12, "The last level measured"},
    {"--runs", &Settings::runs, 1, 1000, "Turns; the figures are medians of all turns"},
    {"--reads", &Settings::reads, 64, 100000000, "Reads of all threads"},
    {"--queries", &Settings::queries, 1, 100000000, "Queries of a run"},
    {"--samples", &Settings::samples, 1000, 100000000, "Points on each surface"},
    {"--points", &Settings::points, 1, 1024, "Points of a row"},
    {"--blocks", &Settings::blocks, 1, 1000000, "Blocks of each attribute, at the same distance"},
    {"--block", &Settings::block_kib, 4, 1 << 20, "Size of a block, KiB"},
    {"--budget", &Settings::budget_mib, 0, 1 << 20,
     "Budget for blocks in memory, MiB; 0: enough for the whole store"},
};

constexpr struct {
  const char* name;
  std::string Settings::*value;
  const char* help;
} kTexts[] = {
    {"--mesh", &Settings::mesh, "PLY, OBJ or OFF; default: a mesh that the program makes"},
    {"--other", &Settings::other, "Another mesh, if there is a --mesh"},
    {"--only", &Settings::only, "Only what has this text in its name"},
    {"--directory", &Settings::directory, "Where to make temporary files: on the disk to measure"},
};

constexpr struct {
  const char* name;
  std::vector<std::string> Settings::*values;
  const char* help;
} kLists[] = {
    {"--backend", &Settings::backends, "Backends, several with commas"},
    {"--layouts", &Settings::layouts, "Orders of the faces, several with commas"},
};

void add_option(CommandLine& to, Settings& settings, std::string_view name) {
  for (const auto& each : kNumbers)
    if (name == each.name)
      to.add_option(each.name, settings.*each.value, each.help)
          ->range(each.first, each.last)
          ->capture_default_str();
  for (const auto& each : kTexts)
    if (name == each.name)
      to.add_option(each.name, settings.*each.value, each.help)->capture_default_str();
  for (const auto& each : kLists)
    if (name == each.name)
      to.add_option(each.name, settings.*each.values, each.help)->delimiter(',');
  if (name == "--threads")
    to.add_option("--threads", settings.threads, "Numbers of threads, several with commas")
        ->delimiter(',')
        ->range(1, 64);
}

volatile sig_atomic_t received_signal = 0;

/// After a signal, the next call of say_progress() ends the measurement. A second signal ends the
/// process at once, and the next run removes what this one left.
void keep_signals() {
  struct sigaction action {};
  action.sa_handler = [](int number) { received_signal = number; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(number, &action, nullptr);
}

}  // namespace

Program::Program(const char* name, const char* description, Settings defaults,
                 std::initializer_list<const char*> options)
    : name_(name), settings_(std::move(defaults)), options_(description, name) {
  for (const char* option : options) add_option(options_, settings_, option);
}

int Program::run(int count, char** words, void (*measure)(const Settings&)) {
  return run(count, words, [&] {
    measure(settings_);
    return 0;
  });
}

int Program::run(int count, char** words, const std::function<int()>& measure) try {
  if (options_.parse(count, words) == CommandLine::Outcome::kAnswered) {
    std::fputs(options_.answer().c_str(), stdout);
    return 0;
  }
  if (!options_.has_option("--directory")) return measure();
  keep_signals();  // before the directory exists, so that no signal can leave it behind
  const instrument::ScratchDirectory scratch(settings_.directory);
  settings_.directory = scratch.path().native();
  return measure();
} catch (const UsageError& error) {
  return fail(fmt::format("{} (see --help)", error.what()), 2);
} catch (const std::exception& error) {
  return fail(error.what(), received_signal == 0 ? 1 : 128 + received_signal);
} catch (...) {
  return 1;
}

int Program::fail(const std::string& why, int status) const {
  std::fputs(fmt::format("{}: {}\n", name_, why).c_str(), stderr);
  return status;
}

void say_progress(const std::string& text) {
  if (received_signal != 0) throw Error(ErrorCode::kCancelled, "cancelled by a signal");
  if (::isatty(STDERR_FILENO) == 1) std::fputs((text + "\n").c_str(), stderr);
}

}  // namespace plait::bench
