// plait verify: reads every block and names each bad one.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "measure.h"
#include "plait/store.h"
#include "plait/verify.h"
#include "progress.h"

namespace plait {
namespace {

nlohmann::ordered_json json_report(const std::filesystem::path& path, const VerifyReport& report,
                                   double seconds) {
  nlohmann::ordered_json damaged = nlohmann::ordered_json::array();
  for (const DamagedBlock& block : report.damaged)
    damaged.push_back({{"attribute", block.attribute},
                       {"level", block.level},
                       {"block", block.block},
                       {"file_offset", block.file_offset},
                       {"first_edge", block.first_edge},
                       {"edge_after", block.edge_after},
                       {"reason", block.reason}});
  return {{"store", path.string()},
          {"ok", report.damaged_count == 0},
          {"blocks", report.blocks},
          {"bytes", report.bytes},
          {"never_written", report.never_written},
          {"damaged_count", report.damaged_count},
          {"damaged", std::move(damaged)},
          {"seconds", seconds}};
}

void print_report(const std::filesystem::path& path, const VerifyReport& report, double seconds) {
  for (const DamagedBlock& block : report.damaged)
    print(fmt::format("damaged: {}, level {}, block {}, file offset {}, edges {} to {}: {}\n",
                      block.attribute, block.level, block.block, block.file_offset,
                      block.first_edge, block.edge_after - 1, block.reason));
  if (report.damaged_count > report.damaged.size())
    print(fmt::format("and {} more\n", report.damaged_count - report.damaged.size()));
  print(fmt::format("{}: {} in {} blocks read and checked, {:.2f} s: ", path.native(),
                    format_bytes(report.bytes), format_count(report.blocks), seconds));
  print(report.damaged_count == 0
            ? std::string("whole\n")
            : fmt::format("{} damaged\n", format_count(report.damaged_count)));
}

int run(const std::filesystem::path& path, const CommandContext& context) {
  const Stopwatch clock;
  Store store = Store::open(path, OpenOptions(), context.backends);
  Progress progress("verify", ProgressUnit::kBytes);
  const VerifyReport report = verify(
      store, [&](std::uint64_t done, std::uint64_t total) { return progress.update(done, total); });
  progress.clear();
  if (context.json)
    print(json_report(path, report, clock.seconds()).dump(2) + "\n");
  else
    print_report(path, report, clock.seconds());
  return report.damaged_count == 0 ? kExitDone : kExitFailed;
}

}  // namespace

void add_verify_command(CLI::App& program, CommandContext& context) {
  const auto path = std::make_shared<std::filesystem::path>();
  CLI::App* command = program.add_subcommand("verify", "Read everything in a store and check it");
  command->add_option("STORE", *path, "The store")->required();
  add_json_option(*command, context);
  command->footer(
      "Ends with status 1 if anything is damaged; each bad block is named by attribute, level,\n"
      "block, file offset and edges (the first 1,000 of them).\n"
      "\n"
      "Examples:\n"
      "  plait verify surface.plait\n"
      "  plait verify surface.plait --json");
  command->callback(
      [path, &context] { context.run = [path, &context] { return run(*path, context); }; });
}

}  // namespace plait
