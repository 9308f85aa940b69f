// plait clean: what killed runs left in a directory, and its removal.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "plait/directory.h"
#include "plait/left_overs.h"

namespace plait {
namespace {

struct Arguments {
  std::filesystem::path directory;
  bool dry_run = false;
};

struct Cleaned {
  LeftOver left_over;
  bool removed = false;  ///< with --dry-run: would be
};

std::string text_of(const Cleaned& cleaned, bool dry_run) {
  const LeftOver& left_over = cleaned.left_over;
  const std::string figures = fmt::format("{} ({})", left_over.name, format_bytes(left_over.bytes));
  if (left_over.in_use) return fmt::format("in use: {}\n", figures);
  if (cleaned.removed) return fmt::format("{}: {}\n", dry_run ? "left over" : "removed", figures);
  return fmt::format("stays: {}, since it holds {}\n", figures, fmt::join(left_over.foreign, ", "));
}

int run(const Arguments& arguments, const CommandContext& context) {
  const Directory directory(arguments.directory);
  std::vector<Cleaned> all;
  std::uint64_t removed_bytes = 0, removed_count = 0;
  for (LeftOver& left_over : find_left_overs(directory)) {
    Cleaned& cleaned = all.emplace_back();
    if (!left_over.in_use)
      cleaned.removed =
          arguments.dry_run ? left_over.foreign.empty() : remove_left_over(directory, left_over);
    if (cleaned.removed) {
      removed_bytes += left_over.bytes;
      ++removed_count;
    }
    cleaned.left_over = std::move(left_over);
  }
  if (context.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Cleaned& cleaned : all)
      list.push_back({{"name", cleaned.left_over.name},
                      {"bytes", cleaned.left_over.bytes},
                      {"in_use", cleaned.left_over.in_use},
                      {"removed", cleaned.removed && !arguments.dry_run},
                      {"foreign", cleaned.left_over.foreign}});
    const nlohmann::ordered_json report = {{"directory", arguments.directory.string()},
                                           {"dry_run", arguments.dry_run},
                                           {"left_over", list},
                                           {"count", removed_count},
                                           {"bytes", removed_bytes}};
    print(report.dump(2) + "\n");
    return kExitDone;
  }
  std::string text;
  for (const Cleaned& cleaned : all) text += text_of(cleaned, arguments.dry_run);
  print(text + fmt::format("{}: {} of killed runs {}, {}\n", arguments.directory.native(),
                           removed_count, arguments.dry_run ? "can be removed" : "removed",
                           format_bytes(removed_bytes)));
  return kExitDone;
}

}  // namespace

void add_clean_command(CLI::App& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program.add_subcommand("clean", "Remove what killed runs left in a directory");
  command->add_option("DIR", arguments->directory, "The directory that outputs are made in")
      ->required();
  command->add_flag("--dry-run", arguments->dry_run, "List it and remove nothing");
  add_json_option(*command, context);
  command->footer(
      "Outputs are made as NAME.partial-PID, and repair works in STORE.repair-PID. A run that is\n"
      "killed leaves them; the next run of the same name removes them, and this command those of\n"
      "every name. What a running process has locked stays, and so does every file in them that\n"
      "plait did not make.\n"
      "\n"
      "Examples:\n"
      "  plait clean . --dry-run\n"
      "  plait clean /scratch/surfaces\n"
      "  plait clean . --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
