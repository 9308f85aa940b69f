// plait clean: removes files that killed runs left in a directory.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "instrument/memory_limit.h"
#include "instrument/scratch_directory.h"
#include "json_text.h"
#include "plait/error.h"
#include "plait/extend/directory.h"
#include "store/left_overs.h"
#include "store/old_versions.h"
#include "store/store_directory.h"

namespace plait {
namespace {

struct CleanArguments {
  std::filesystem::path directory;
  bool dry_run = false;
  std::string keep = "24h";
};

/// "24h", "90min", "7d" or "0s".
std::chrono::seconds duration_in(const std::string& text) {
  const std::size_t unit_at = text.find_first_not_of("0123456789");
  const std::string unit = unit_at == std::string::npos ? "" : text.substr(unit_at);
  const std::map<std::string, int> seconds = {{"s", 1}, {"min", 60}, {"h", 3600}, {"d", 86400}};
  if (unit_at == 0 || unit_at > 9 || !seconds.contains(unit))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("clean: --keep {}: expected a time such as 24h, 90min, 7d or 0s", text));
  return std::chrono::seconds(std::stoll(text.substr(0, unit_at)) * seconds.at(unit));
}

struct Cleaned {
  LeftOver left_over;
  bool removed = false;  ///< with --dry-run: whether it could be
};

std::string cleaned_text(const Cleaned& cleaned, bool dry_run) {
  const LeftOver& left_over = cleaned.left_over;
  const std::string figures = fmt::format("{} ({})", left_over.name, format_bytes(left_over.bytes));
  if (left_over.in_use) return fmt::format("in use: {}\n", figures);
  if (cleaned.removed) return fmt::format("{}: {}\n", dry_run ? "left over" : "removed", figures);
  if (left_over.foreign.empty())
    return fmt::format("stays: {}, because some of its files cannot be removed\n", figures);
  return fmt::format("stays: {}, because plait did not make {}\n", figures,
                     fmt::join(left_over.foreign, ", "));
}

/// What measurements left: scratch directories here, and control groups of the machine.
std::vector<Cleaned> clean_measurements(const CleanArguments& arguments) {
  std::vector<Cleaned> all;
  for (const instrument::FoundScratch& found :
       instrument::find_scratch(arguments.directory, !arguments.dry_run))
    all.push_back({{found.name, found.in_use, found.bytes, {}},
                   arguments.dry_run ? !found.in_use : found.removed});
  for (const std::filesystem::path& group :
       instrument::MemoryLimit::dead_groups(!arguments.dry_run))
    all.push_back({{group.native(), false, 0, {}}, true});
  return all;
}

/// What killed runs left in one directory. `shown` goes before the names.
std::vector<Cleaned> clean_directory(const Directory& directory, std::string_view of,
                                     const std::string& shown, bool dry_run) {
  std::vector<Cleaned> all;
  for (LeftOver& left_over : find_left_overs(directory, of)) {
    Cleaned& cleaned = all.emplace_back();
    if (!left_over.in_use)
      cleaned.removed =
          dry_run ? left_over.foreign.empty() : remove_left_over(directory, left_over);
    left_over.name = shown + left_over.name;
    cleaned.left_over = std::move(left_over);
  }
  return all;
}

/// What killed repairs left inside the stores of the directory.
std::vector<Cleaned> clean_stores(const Directory& directory, bool dry_run) {
  std::vector<Cleaned> all;
  for (const std::string& name : directory.names()) try {
      const Directory store(directory, name);
      if (is_store(store))
        for (Cleaned& one : clean_directory(store, kRepairStem, name + "/", dry_run))
          all.push_back(std::move(one));
    } catch (const Error&) {  // not a directory, not readable, or not a store
    }
  return all;
}

int run_clean(const CleanArguments& arguments, const CommandContext& context) {
  const std::chrono::seconds keep = duration_in(arguments.keep);
  const Directory directory(arguments.directory);
  int status = kExitDone;
  std::optional<RemovedVersions> old;
  try {
    if (is_store(directory))
      old = remove_versions_replaced_before(directory, keep, arguments.dry_run);
  } catch (const Error& error) {  // a writer has the store, or it is damaged
    report_warning(error.what());
    status = kExitFailed;
  }
  std::vector<Cleaned> all = clean_measurements(arguments);
  std::uint64_t removed_bytes = 0, removed_count = 0;
  for (const std::vector<Cleaned>& found : {clean_directory(directory, {}, "", arguments.dry_run),
                                            clean_stores(directory, arguments.dry_run)})
    for (const Cleaned& cleaned : found) {
      if (!cleaned.left_over.in_use && !cleaned.removed && cleaned.left_over.foreign.empty())
        status = kExitFailed;
      all.push_back(cleaned);
    }
  for (const Cleaned& cleaned : all)
    if (cleaned.removed) {
      removed_bytes += cleaned.left_over.bytes;
      ++removed_count;
    }
  if (context.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Cleaned& cleaned : all)
      list.push_back({{"name", cleaned.left_over.name},
                      {"bytes", cleaned.left_over.bytes},
                      {"in_use", cleaned.left_over.in_use},
                      {"removed", cleaned.removed && !arguments.dry_run},
                      {"foreign", cleaned.left_over.foreign}});
    nlohmann::ordered_json report = {{"directory", arguments.directory.string()},
                                     {"dry_run", arguments.dry_run},
                                     {"left_over", list},
                                     {"count", removed_count},
                                     {"bytes", removed_bytes}};
    if (old)
      report["old_versions"] = {
          {"files", old->files}, {"bytes", old->bytes}, {"versions_kept", old->versions_kept}};
    print(json_text(report));
    return status;
  }
  std::string text;
  if (old)
    text += fmt::format(
        "{}: {} files of old versions {}, {}; {} old versions may be read and stay\n",
        arguments.directory.native(), old->files, arguments.dry_run ? "can be removed" : "removed",
        format_bytes(old->bytes), old->versions_kept);
  for (const Cleaned& cleaned : all) text += cleaned_text(cleaned, arguments.dry_run);
  print(text + fmt::format("{}: {} of killed runs {}, {}\n", arguments.directory.native(),
                           removed_count, arguments.dry_run ? "can be removed" : "removed",
                           format_bytes(removed_bytes)));
  return status;
}

}  // namespace

void add_clean_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<CleanArguments>();
  CommandLine* command =
      program.add_subcommand("clean", "Remove files that killed runs left in a directory");
  command->add_option("DIR", arguments->directory, "The directory of the outputs")->required();
  command->add_flag("--dry-run", arguments->dry_run, "List the files, but remove nothing");
  command->add_option("--keep", arguments->keep,
                      "Of a store: how long readers on other machines keep a version that was "
                      "replaced; default 24h");
  add_json_option(*command, context);
  command->footer(
      "plait makes an output in a directory NAME.partial-HOST-START-PROCESS.RANDOM; repair works\n"
      "inside the store, in STORE/scratch.repair-... If a run is killed, these directories stay. "
      "The next run "
      "of\n"
      "this host with the same output, or the next writer of the store, removes them; those of "
      "other\n"
      "hosts are listed as in use. The command looks into stores that are in DIR too. bench,\n"
      "tune and paper work in plait-scratch-XXXXXX and in control groups. This command removes "
      "those\n"
      "of all outputs and of all killed runs. It removes no directory that a running process has\n"
      "locked, and only directories that prove by their content that plait made them: by the file\n"
      "plait-made or by the manifest of a store. An empty one is removed too. The exit status is 1 "
      "if\n"
      "a file of plait's cannot be removed.\n"
      "\n"
      "If DIR is a store, the command also removes files of old versions. Commits do that where "
      "the\n"
      "locks of readers are seen. On a file system of a network the files stay, and this command\n"
      "removes those of versions that were replaced longer ago than --keep.\n"
      "\n"
      "Examples:\n"
      "  plait clean . --dry-run\n"
      "  plait clean /scratch/surfaces\n"
      "  plait clean statue.plait --keep 7d\n"
      "  plait clean . --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_clean(*arguments, context); };
  });
}

}  // namespace plait
