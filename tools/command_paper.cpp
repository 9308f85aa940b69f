// plait paper: the tables and figures of the paper that plait's index comes from, beside our own.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "instrument/scratch_directory.h"
#include "interrupt.h"
#include "json_text.h"
#include "paper/report.h"
#include "plait/error.h"
#include "progress.h"
#include "store/new_output.h"

namespace plait {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct PaperArguments {
  paper::ReportRequest request;
  std::vector<std::string> memory;
  fs::path markdown, pictures;
  bool no_runs = false, force = false;
};

constexpr const char* kBackendsThatAreLeft = "all that work on this machine";

void refuse(const std::string& message) { throw Error(ErrorCode::kInvalidArgument, message); }

void make_directories(const fs::path& path) {
  std::error_code failed;
  fs::create_directories(path, failed);
  if (failed) throw system_error("create", path.native(), failed.value());
}

/// The work is done in child processes of this one, so this one must not start threads.
paper::ReportRequest paper_request_of(const PaperArguments& arguments) {
  paper::ReportRequest request = arguments.request;
  for (const std::string& text : arguments.memory) request.budgets.push_back(parse_size(text));
  request.runs = !arguments.no_runs;
  request.pictures_directory = arguments.pictures;
  for (const fs::path& directory : {request.directory, arguments.pictures})
    if (!directory.empty() && !fs::is_directory(directory))
      refuse("paper: " + directory.native() + ": expected a directory, found none");
  if (arguments.markdown.empty()) return request;
  require_extension("write", arguments.markdown, ".md");
  make_directories(fs::absolute(arguments.markdown).parent_path());
  UnpublishedFile::check(arguments.markdown,
                         arguments.force ? Existing::kReplace : Existing::kRefuse);
  if (arguments.pictures.empty()) {
    request.pictures_directory = arguments.markdown.parent_path() / "images";
    make_directories(request.pictures_directory);
  }
  return request;
}

int run_paper(const PaperArguments& arguments, const CommandContext& context) {
  const paper::ReportRequest request = paper_request_of(arguments);
  const instrument::ScratchDirectory scratch(request.directory);
  ProgressBar progress("paper", ProgressUnit::kNone);
  Json report = paper::make_report(
      request, context.backends,
      [&](std::size_t done, std::size_t total, const std::string& next) {
        progress.update(done, total, next);
      },
      scratch.path());
  progress.clear();

  const instrument::Page chapter = paper::make_chapter(report);
  const bool interrupted = report["interrupted"].get<bool>();
  if (!arguments.markdown.empty()) {
    const fs::path directory = arguments.markdown.parent_path();
    const std::string text = to_markdown(chapter, directory.empty() ? "." : directory);
    make_new_file(arguments.markdown, arguments.force ? Existing::kReplace : Existing::kRefuse,
                  report_warning, [&](UnpublishedFile& output) {
                    output.file().write_at(0, std::as_bytes(std::span(text)));
                  });
  }
  print(context.json ? json_text(report) : to_text(chapter));
  if (interrupted) return kExitSignalBase + interrupt_signal();
  return report["failed"].get<bool>() ? kExitFailed : kExitDone;
}

void add_what(CommandLine& command, PaperArguments& arguments) {
  paper::ReportRequest& request = arguments.request;
  command.add_option("--model", request.models, "deo, david or buddha, or several with commas")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--mesh", request.mesh, "A mesh instead of the generated stand-in")
      ->type_name("FILE");
  add_whole_option(command, "--vertices", request.vertices, 4, 100'000'000,
                   "A stand-in with this number of vertices, to try the command");
  add_whole_option(command, "--levels", request.levels, 1, 12, "The level; default: the paper's");
  command
      .add_option("--executor", request.executors,
                  "paper (the paper's own way), fused, sweep or transparent")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--backend", request.backends, "Backends, with commas")
      ->delimiter(',')
      ->default_str(kBackendsThatAreLeft);
  command
      .add_option(
          "--memory", arguments.memory,
          "Budgets, with commas; default: the paper's buffers, at least 64 MiB, and for deo "
          "four times that")
      ->delimiter(',')
      ->type_name("SIZE");
  add_size_option(command, "--limit", request.limit_bytes,
                  "A memory limit around each run (cgroup), page cache included")
      ->default_str("none");
  add_threads_option(command, request.threads, "Worker threads of fused and sweep");
}

void add_output(CommandLine& command, PaperArguments& arguments) {
  command.add_flag("--no-runs", arguments.no_runs, "Only counts, spans and pictures");
  command
      .add_option("--directory", arguments.request.directory,
                  "Where stores are made, and removed after each run")
      ->type_name("DIR")
      ->capture_default_str();
  add_output_option(command, "--markdown", arguments.markdown, "Write the chapter: NAME.md");
  command
      .add_option(
          "--pictures", arguments.pictures,
          "Draw the figures into DIR; default with --markdown: images beside it, made if absent")
      ->type_name("DIR");
  command.add_flag("--force", arguments.force, "Replace NAME.md if it exists");
}

}  // namespace

void add_paper_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<PaperArguments>();
  CommandLine* command = program.add_subcommand(
      "paper", "The tables and figures of the paper that plait is made after, beside our own");
  add_what(*command, *arguments);
  add_output(*command, *arguments);
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The paper: I. Guskov, \"Non-replicating indexing for out-of-core processing of "
      "semi-regular\n"
      "triangular surface meshes\". Its meshes are not distributed with plait; stand-ins with the\n"
      "same numbers of vertices and edges are generated. Each run has a process of its own, makes\n"
      "positions and normals, and ends with a commit. A tenth of the disk stays free. After "
      "Ctrl-C\n"
      "the command reports what it has.\n"
      "\n"
      "Examples:\n"
      "  plait paper --no-runs --mesh deo.ply --pictures .\n"
      "  plait paper --model deo --backend pread,uring --markdown paper.md\n"
      "  plait paper --vertices 500 --levels 3");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_paper(*arguments, context); };
  });
}

}  // namespace plait
