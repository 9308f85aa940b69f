// plait repair: rebuilds damaged files and blocks that can be computed again, and lists the others.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "json_text.h"
#include "measure.h"
#include "plait/verify.h"
#include "progress.h"
#include "report_text.h"

namespace plait {
namespace {

struct RepairArguments {
  std::filesystem::path store;
  bool dry_run = false;
  std::uint64_t memory_bytes = RepairOptions().budget_bytes;
};

nlohmann::ordered_json json_files(const std::vector<RepairedFile>& files) {
  nlohmann::ordered_json result = nlohmann::ordered_json::array();
  for (const RepairedFile& file : files)
    result.push_back({{"file", file.name}, {"reason", file.reason}});
  return result;
}

nlohmann::ordered_json repair_json(const RepairArguments& arguments, const RepairReport& report,
                                   double seconds) {
  return {{"store", arguments.store.string()},
          {"ok", report.whole()},
          {"dry_run", arguments.dry_run},
          {"version", report.version},
          {"files", report.files},
          {"rebuilt_files", json_files(report.rebuilt_files)},
          {"lost_files", json_files(report.lost_files)},
          {"blocks_read", report.blocks_examined},
          {"blocks", report.blocks},
          {"bytes", report.bytes},
          {"rebuilt_count", report.rebuilt_count},
          {"rebuilt", to_json(report.rebuilt)},
          {"lost_count", report.lost_count},
          {"lost", to_json(report.lost)},
          {"left_over", report.left_over},
          {"notes", report.notes},
          {"seconds", seconds}};
}

/// "2 files and 1 block", "nothing".
std::string amount(std::size_t files, std::uint64_t blocks) {
  std::string text;
  if (files > 0) text += fmt::format("{} file{}", files, files == 1 ? "" : "s");
  if (files > 0 && blocks > 0) text += " and ";
  if (blocks > 0) text += fmt::format("{} block{}", format_count(blocks), blocks == 1 ? "" : "s");
  return text.empty() ? "nothing" : text;
}

std::string repair_text(const RepairArguments& arguments, const RepairReport& report,
                        double seconds) {
  const std::string rebuilt = arguments.dry_run ? "can be rebuilt" : "rebuilt";
  std::string text;
  for (const RepairedFile& file : report.lost_files)
    text += fmt::format("lost: {}: {}\n", file.name, file.reason);
  text += to_text("lost", report.lost, report.lost_count);
  for (const RepairedFile& file : report.rebuilt_files)
    text += fmt::format("{}: {}: {}\n", rebuilt, file.name, file.reason);
  text += to_text(rebuilt, report.rebuilt, report.rebuilt_count);
  text += to_text(report.left_over, report.notes);
  text += fmt::format("{}: {} files", arguments.store.native(), report.files);
  text +=
      report.blocks_examined
          ? fmt::format(" and {} in {} blocks checked, {:.2f} s: ", format_bytes(report.bytes),
                        format_count(report.blocks), seconds)
          : fmt::format(" checked, blocks not read because the store cannot be opened, {:.2f} s: ",
                        seconds);
  const std::string done = amount(report.rebuilt_files.size(), report.rebuilt_count);
  if (report.whole() && done == "nothing") return text + "no damage, nothing to repair\n";
  text += fmt::format("{} {}", done, rebuilt);
  if (report.whole())
    return text + (arguments.dry_run ? "; nothing changed\n" : "; no damage is left\n");
  return text + fmt::format("; lost: {}\n", amount(report.lost_files.size(), report.lost_count));
}

int run_repair(const RepairArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  ProgressBar progress("repair", ProgressUnit::kNone);
  RepairOptions options;
  options.dry_run = arguments.dry_run;
  options.budget_bytes = arguments.memory_bytes;
  options.progress = [&](const Progress& now) {
    return progress.update(now.done, now.total, now.phase);
  };
  const RepairReport report = repair(arguments.store, options, context.open_backends);
  progress.clear();
  print(context.json ? json_text(repair_json(arguments, report, clock.seconds()))
                     : repair_text(arguments, report, clock.seconds()));
  return report.whole() ? kExitDone : kExitFailed;
}

}  // namespace

void add_repair_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<RepairArguments>();
  CommandLine* command =
      program.add_subcommand("repair", "Rebuild damaged parts of a store, and list what is lost");
  command->add_option("STORE", arguments->store, "The store")->required();
  command->add_flag("--dry-run", arguments->dry_run,
                    "Print what repair would do, and change nothing");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "What `plait subdivide` made by loop or midpoint is made again, block by block, from the "
      "base\n"
      "mesh. Repair replaces a damaged block only if the new bytes have the checksum that the "
      "store\n"
      "records for the block. All other damaged parts are lost: repair lists them and does not\n"
      "change them.\n"
      "Exit status 0: the store has no damage (with --dry-run: would have none). Status 1:\n"
      "something is lost.\n"
      "\n"
      "Examples:\n"
      "  plait repair surface.plait --dry-run\n"
      "  plait repair surface.plait --memory 2GiB\n"
      "  plait repair surface.plait --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_repair(*arguments, context); };
  });
}

}  // namespace plait
