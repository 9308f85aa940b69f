// The program plait-conformance: runs the conformance suite on one backend.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "command_line/command_line.h"
#include "conformance/suite.h"
#include "console.h"
#include "json_text.h"
#include "plait/error.h"
#include "plait/extend/plugins.h"
#include "plait/version.h"

namespace plait::conformance {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFooter =
    "Makes small levels in new directories below DIR, checks each promise of "
    "plait/extend/backend.h, and\n"
    "removes the directories. A level that is not a file has fewer promises.\n"
    "\n"
    "PLAIT_PLUGINS names more plug-ins, with colons between them.\n"
    "A backend that blocks in a call is not ended. With --json, standard output gets one JSON\n"
    "object: backend, pipeline, held, broken, left_out, and for each promise its name, its text,\n"
    "whether it is held, and the expectations that were not true.\n"
    "\n"
    "Exit status: 0 all promises are kept; 1 one is broken; 2 bad usage, or the plug-in or the\n"
    "backend cannot be used here.\n"
    "\n"
    "Examples:\n"
    "  plait-conformance --plugin ./libmine.so --backend x-mine\n"
    "  plait-conformance --plugin ./libmine.so --backend x-mine --only threads\n"
    "  plait-conformance --plugin ./own_codec.so --backend compressed --pipeline shuffle,x-runs\n"
    "  plait-conformance --backend pread --directory /mnt/disk --json";

struct Arguments {
  std::vector<std::string> plugins;
  std::string backend, pipeline, directory;
  std::vector<std::string> only;
  bool json = false, list = false;
};

Subject subject_of(const Arguments& arguments, const Plugins& plugins) {
  const BackendRegistry& backends = plugins.backends();
  Subject subject;
  subject.label = arguments.backend;
  subject.entry = backends.find(arguments.backend);
  subject.entry.check_machine();
  subject.pipeline =
      arguments.pipeline.empty() ? subject.entry.default_pipeline : Pipeline(arguments.pipeline);
  subject.entry.check_pipelines(subject.pipeline, {});
  subject.directory = arguments.directory;
  if (subject.entry.traits.compressed)
    subject.make_codec = [&plugins, codec = subject.pipeline.codec] {
      return plugins.pipelines().make_codec(codec);
    };
  return subject;
}

Json report_of(const Promise& promise, const CheckLog& log) {
  Json report = {{"name", promise.name}, {"promise", promise.text}, {"held", log.held()}};
  if (!log.left_out().empty()) report["left_out"] = log.left_out();
  if (!log.note().empty()) report["note"] = log.note();
  if (!log.held()) {
    report["expected"] = log.broken();
    report["broken_expectations"] = log.broken_count();
  }
  return report;
}

/// The rest of the line that begins with the name of the promise, and the reasons below it.
std::string text_of(const Promise& promise, const CheckLog& log) {
  if (!log.left_out().empty()) return fmt::format("left out: {}\n", log.left_out());
  if (log.held()) return log.note().empty() ? "kept\n" : fmt::format("kept; {}\n", log.note());
  std::string text = fmt::format("BROKEN: {}\n", promise.text);
  for (const std::string& expected : log.broken())
    text += fmt::format("    expected that {}\n", expected);
  if (log.broken_count() > log.broken().size())
    text += fmt::format("    {} expectations in all\n", log.broken_count());
  return text;
}

int run_suite(const Arguments& arguments, const Plugins& plugins) {
  const Subject subject = subject_of(arguments, plugins);
  const auto wanted = [&](const Promise& promise) {
    if (!promise.concerns(subject.entry.traits)) return false;
    if (arguments.only.empty()) return true;
    for (const std::string& name : arguments.only)
      if (name == promise.name) return true;
    return false;
  };
  std::uint64_t held = 0, broken = 0, left_out = 0;
  Json reports = Json::array();
  for (const Promise& promise : promises()) {
    if (!wanted(promise)) continue;
    if (!arguments.json) {
      print(fmt::format("{:<26} ", promise.name));
      flush_output();  // so that a backend which crashes leaves the name of the promise
    }
    const CheckLog log = check(promise, subject);
    ++(!log.held() ? broken : log.left_out().empty() ? held : left_out);
    if (arguments.json)
      reports.push_back(report_of(promise, log));
    else
      print(text_of(promise, log));
  }
  if (arguments.json)
    print(json_text(Json{{"backend", subject.label},
                         {"pipeline", subject.pipeline.to_text()},
                         {"held", held},
                         {"broken", broken},
                         {"left_out", left_out},
                         {"promises", std::move(reports)}}));
  else
    print(fmt::format("{}, pipeline {}: {} promises kept, {} broken, {} left out\n", subject.label,
                      subject.pipeline.to_text(), held, broken, left_out));
  return broken == 0 ? kExitDone : kExitFailed;
}

void require_known(const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (std::ranges::find(promises(), name, &Promise::name) == promises().end())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("--only: expected a promise that --list names, found \"{}\"", name));
}

int list_promises() {
  for (const Promise& promise : promises())
    print(fmt::format("{:<26} {}\n", promise.name, promise.text));
  return kExitDone;
}

void add_options(CommandLine& program, Arguments& arguments) {
  program.version(std::string("plait-conformance ") + PLAIT_VERSION);
  program
      .add_option("--plugin", arguments.plugins,
                  "Load a plug-in, a shared library (may be repeated)")
      ->type_name("FILE")
      ->allow_extra_args(false);
  program.add_option("--backend", arguments.backend, "The backend, NAME or NAME:KEY=VALUE,...");
  program.add_option("--pipeline", arguments.pipeline,
                     "FILTERS,CODEC of the levels; default: that of the backend");
  program
      .add_option("--directory", arguments.directory,
                  "Where files are made; default: the directory for temporary files")
      ->type_name("DIR");
  program
      .add_option("--only", arguments.only, "Check only this promise; may be repeated; see --list")
      ->type_name("PROMISE")
      ->allow_extra_args(false);
  program.add_flag("--list", arguments.list, "List the promises and do nothing else");
  program.add_flag("--json", arguments.json,
                   "Print one JSON object, and nothing else, to standard output");
  program.help_column(30);
  program.footer(kFooter);
}

int run_program(int argument_count, char** words) {
  Arguments arguments;
  CommandLine program("Check that a backend keeps the promises of plait/extend/backend.h",
                      "plait-conformance");
  add_options(program, arguments);
  try {
    if (program.parse(argument_count, words) == CommandLine::Outcome::kAnswered) {
      print(program.answer());
      flush_output();
      return kExitDone;
    }
  } catch (const UsageError& stopped) {
    report_error("usage", std::string(stopped.what()) + " (see plait-conformance --help)",
                 arguments.json);
    return kExitRefused;
  }
  try {
    if (arguments.list) return list_promises();
    if (arguments.backend.empty())
      throw Error(ErrorCode::kInvalidArgument,
                  "expected --backend NAME (see plait-conformance --help)");
    require_known(arguments.only);
    Plugins plugins;
    if (const char* const list = ::secure_getenv("PLAIT_PLUGINS")) plugins.load_list(list);
    for (const std::string& file : arguments.plugins) plugins.load(file);
    const int status = run_suite(arguments, plugins);
    flush_output();
    return status;
  } catch (const Error& error) {
    report_error(to_string(error.code()), error.what(), arguments.json);
    return exit_status(error.code());
  }
}

}  // namespace
}  // namespace plait::conformance

int main(int argument_count, char** words) {
  try {
    return plait::conformance::run_program(argument_count, words);
  } catch (const std::exception& error) {
    plait::report_error("internal", error.what(), false);
    return plait::kExitFailed;
  }
}
