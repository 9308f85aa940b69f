// plait verify: reads every block and names each bad one; or, fast, only what does not depend on
// the size of the levels.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "damage_report.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/store.h"
#include "plait/structure.h"
#include "plait/verify.h"
#include "progress.h"

namespace plait {
namespace {

struct Arguments {
  std::filesystem::path store;
  bool fast = false;
};

struct Findings {
  StoreStructure structure;
  std::optional<VerifyReport> blocks;  ///< none: they were not read
  double seconds = 0;
  bool whole() const {
    return structure.damaged.empty() && (!blocks || blocks->damaged_count == 0);
  }
};

nlohmann::ordered_json json_report(const Arguments& arguments, const Findings& found) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const DamagedFile& file : found.structure.damaged)
    files.push_back({{"file", file.name}, {"reason", file.reason}});
  const VerifyReport blocks = found.blocks.value_or(VerifyReport());
  return {{"store", arguments.store.string()},
          {"ok", found.whole()},
          {"version", found.structure.sequence},
          {"files", found.structure.files},
          {"damaged_files", std::move(files)},
          {"blocks_read", found.blocks.has_value()},
          {"blocks", blocks.blocks},
          {"bytes", blocks.bytes},
          {"never_written", blocks.never_written},
          {"damaged_count", blocks.damaged_count},
          {"damaged", to_json(blocks.damaged)},
          {"left_over", found.structure.left_over},
          {"notes", found.structure.notes},
          {"seconds", found.seconds}};
}

std::string text_report(const Arguments& arguments, const Findings& found) {
  std::string text;
  for (const DamagedFile& file : found.structure.damaged)
    text += fmt::format("damaged: {}: {}\n", file.name, file.reason);
  if (found.blocks) text += to_text("damaged", found.blocks->damaged, found.blocks->damaged_count);
  text += to_text(found.structure.left_over, found.structure.notes);
  const std::string name = arguments.store.native();
  if (!found.structure.damaged.empty())
    return text + fmt::format(
                      "{}: {} files checked, {} damaged; it cannot be opened, so no block "
                      "was read\n",
                      name, found.structure.files, found.structure.damaged.size());
  if (!found.blocks)
    return text + fmt::format(
                      "{}: version {}, {} files: sizes, extents, and the checksums of manifest, "
                      "base mesh, base records and block tables checked, blocks not read, "
                      "{:.2f} s: no damage\n",
                      name, found.structure.sequence, found.structure.files, found.seconds);
  return text + fmt::format("{}: {} in {} blocks read and checked, {:.2f} s: {}\n", name,
                            format_bytes(found.blocks->bytes), format_count(found.blocks->blocks),
                            found.seconds,
                            found.whole() ? std::string("whole")
                                          : format_count(found.blocks->damaged_count) + " damaged");
}

int run(const Arguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  Findings found;
  found.structure = check_structure(arguments.store, context.open_backends);
  throw_if_interrupted();
  if (found.structure.damaged.empty()) {
    found.structure.base = BaseMesh();  // the store has its own
    Store store = Store::open(arguments.store, OpenOptions(), context.open_backends);
    Progress progress("verify", ProgressUnit::kBytes);
    if (!arguments.fast)
      found.blocks = verify(store, [&](std::uint64_t done, std::uint64_t total) {
        return progress.update(done, total);
      });
  }
  found.seconds = clock.seconds();
  print(context.json ? json_report(arguments, found).dump(2) + "\n"
                     : text_report(arguments, found));
  return found.whole() ? kExitDone : kExitFailed;
}

}  // namespace

void add_verify_command(CLI::App& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("verify", "Read everything in a store and check it");
  command->add_option("STORE", arguments->store, "The store")->required();
  command->add_flag("--fast", arguments->fast,
                    "Check all but the blocks: manifest, base mesh, base records, block tables, "
                    "sizes and extents of the levels");
  add_json_option(*command, context);
  command->footer(
      "Ends with status 1 if anything is damaged. Every bad file of the version is named; and, if\n"
      "none is so bad that the store cannot be opened, each bad block by attribute, level, block,\n"
      "file offset and edges (the first 1,000 of them). `plait repair` rebuilds what it can.\n"
      "Files that no version refers to and a bad older manifest slot are named, but are no "
      "damage.\n"
      "\n"
      "Examples:\n"
      "  plait verify surface.plait\n"
      "  plait verify surface.plait --fast\n"
      "  plait verify surface.plait --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
