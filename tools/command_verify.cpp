// plait verify: checks a store. It reads every block and names each damaged one. With --fast it
// reads only the parts whose size does not depend on the levels.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/extend/check_store.h"
#include "plait/store.h"
#include "plait/verify.h"
#include "progress.h"
#include "report_text.h"

namespace plait {
namespace {

struct VerifyArguments {
  std::filesystem::path store;
  bool fast = false;
};

struct VerifyFindings {
  StoreCheck check;
  std::optional<VerifyReport> blocks;  ///< empty if they were not read
  double seconds = 0;
  bool whole() const { return check.damaged.empty() && (!blocks || blocks->damaged_count == 0); }
};

nlohmann::ordered_json verify_json(const VerifyArguments& arguments, const VerifyFindings& found) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const DamagedFile& file : found.check.damaged)
    files.push_back({{"file", file.name}, {"reason", file.reason}});
  const VerifyReport blocks = found.blocks.value_or(VerifyReport());
  return {{"store", arguments.store.string()},
          {"ok", found.whole()},
          {"version", found.check.sequence},
          {"files", found.check.files},
          {"damaged_files", std::move(files)},
          {"blocks_read", found.blocks.has_value()},
          {"blocks", blocks.blocks},
          {"bytes", blocks.bytes},
          {"never_written", blocks.never_written},
          {"damaged_count", blocks.damaged_count},
          {"damaged", to_json(blocks.damaged)},
          {"left_over", found.check.left_over},
          {"notes", found.check.notes},
          {"seconds", found.seconds}};
}

std::string verify_text(const VerifyArguments& arguments, const VerifyFindings& found) {
  std::string text;
  for (const DamagedFile& file : found.check.damaged)
    text += fmt::format("damaged: {}: {}\n", file.name, file.reason);
  if (found.blocks) text += to_text("damaged", found.blocks->damaged, found.blocks->damaged_count);
  text += to_text(found.check.left_over, found.check.notes);
  const std::string name = arguments.store.native();
  if (!found.check.damaged.empty())
    return text + fmt::format(
                      "{}: {} files checked, {} damaged; the store cannot be opened, so no "
                      "block was read\n",
                      name, found.check.files, found.check.damaged.size());
  if (!found.blocks)
    return text + fmt::format(
                      "{}: version {}, {} files: sizes, extents, and the checksums of manifest, "
                      "base mesh, base records and block tables checked, blocks not read, "
                      "{:.2f} s: no damage\n",
                      name, found.check.sequence, found.check.files, found.seconds);
  return text + fmt::format("{}: {} in {} blocks read and checked, {:.2f} s: {}\n", name,
                            format_bytes(found.blocks->bytes), format_count(found.blocks->blocks),
                            found.seconds,
                            found.whole() ? std::string("whole")
                                          : format_count(found.blocks->damaged_count) + " damaged");
}

int run_verify(const VerifyArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  VerifyFindings found;
  found.check = check_store(arguments.store, context.open_backends);
  if (!found.check.lock.empty())
    found.check.notes.push_back(found.check.lock + "; plait repair makes a new one");
  throw_if_interrupted();
  if (found.check.damaged.empty()) {
    found.check.base = BaseMesh();  // frees memory: the store has its own base mesh
    Store store = Store::open(arguments.store, OpenOptions(), context.open_backends);
    ProgressBar progress("verify", ProgressUnit::kBytes);
    if (!arguments.fast)
      found.blocks =
          verify(store, [&](const Progress& now) { return progress.update(now.done, now.total); });
  }
  found.seconds = clock.seconds();
  print(context.json ? json_text(verify_json(arguments, found)) : verify_text(arguments, found));
  return found.whole() ? kExitDone : kExitFailed;
}

}  // namespace

void add_verify_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<VerifyArguments>();
  CommandLine* command =
      program.add_subcommand("verify", "Read everything in a store and check it");
  command->add_option("STORE", arguments->store, "The store")->required();
  command->add_flag(
      "--fast", arguments->fast,
      "Check everything except blocks: manifest, base mesh, base records, block tables, "
      "sizes and extents of the levels");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Lists every damaged file. If the store can be opened, also lists the damaged blocks, each\n"
      "with attribute, level, block, file offset and edges (the first 1,000 blocks). Exit status "
      "1\n"
      "means that something is damaged; `plait repair` rebuilds what it can. Files that no "
      "version\n"
      "refers to, and a damaged older manifest slot, are listed too, but do not count as damage.\n"
      "\n"
      "Examples:\n"
      "  plait verify surface.plait\n"
      "  plait verify surface.plait --fast\n"
      "  plait verify surface.plait --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_verify(*arguments, context); };
  });
}

}  // namespace plait
