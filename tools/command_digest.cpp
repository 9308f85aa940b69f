// plait digest: prints one number computed from all records of a store.

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
#include "maintenance/decoded_again.h"
#include "measure.h"
#include "plait/digest.h"
#include "plait/store.h"
#include "progress.h"
#include "prune/compare_pruned.h"

namespace plait {
namespace {

struct DigestArguments {
  std::filesystem::path store, against;
  int level = -1;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
  int threads = 1;
};

/// Whether the records are those that the other store has at the same addresses.
int run_comparison(const DigestArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes / 2;
  const Store store = Store::open(arguments.store, open, context.open_backends);
  const Store whole = Store::open(arguments.against, open, context.open_backends);
  ProgressBar progress("compare", ProgressUnit::kNone);
  const PrunedComparison found = compare_pruned(
      store, whole, [&](const Progress& now) { return progress.update(now.done, now.total); });
  progress.clear();
  if (context.json) {
    nlohmann::ordered_json report = {{"store", arguments.store.string()},
                                     {"against", arguments.against.string()},
                                     {"equal", !found.difference},
                                     {"slots", found.slots},
                                     {"records", found.records}};
    if (found.difference) report["difference"] = *found.difference;
    report["seconds"] = clock.seconds();
    print(json_text(report));
  } else if (found.difference) {
    print(fmt::format("{} is not as in {}: {}\n", arguments.store.native(),
                      arguments.against.native(), *found.difference));
  } else {
    print(fmt::format("all {} records in {} slots are as in {}\n", found.records, found.slots,
                      arguments.against.native()));
  }
  return found.difference ? kExitFailed : kExitDone;
}

int run_digest(const DigestArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, context.open_backends);
  ProgressBar progress("digest", ProgressUnit::kNone);
  DigestOptions options;
  options.level = arguments.level;
  options.threads = arguments.threads;
  options.progress = [&](const Progress& now) { return progress.update(now.done, now.total); };
  options.begins = [&](int threads) {
    if (threads < arguments.threads)
      report_warning(
          fmt::format("digest: {} threads of {}: the blocks of more do not fit the "
                      "budget of {} (--memory)",
                      threads, arguments.threads, format_bytes(arguments.memory_bytes)));
  };
  const std::string word = digest(store, options).to_string();
  progress.clear();
  if (const std::string again = decoded_again(store); !again.empty()) report_warning(again);
  if (!context.json) {
    print(word + "\n");
    return kExitDone;
  }
  nlohmann::ordered_json report = {{"store", arguments.store.string()}, {"digest", word}};
  if (arguments.level >= 0) report["level"] = arguments.level;
  report["seconds"] = clock.seconds();
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_digest_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<DigestArguments>();
  CommandLine* command =
      program.add_subcommand("digest", "Print a number computed from all records of a store");
  command->add_option("STORE", arguments->store, "The store")->required();
  Option* const level =
      add_level_option(*command, arguments->level, "Only the vertices that this level creates");
  command
      ->add_option("--against", arguments->against,
                   "Compare every record with the one of the same address in this store, from "
                   "which STORE was pruned, instead")
      ->excludes(level);
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_threads_option(*command, arguments->threads, "Threads");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The last line is one hexadecimal number. It is equal for any backend, codec, block size,\n"
      "budget, executor, thread count and layout.\n"
      "\n"
      "Examples:\n"
      "  plait digest surface.plait\n"
      "  plait digest surface.plait --level 3 --json\n"
      "  plait digest pruned.plait --against surface.plait");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] {
      return arguments->against.empty() ? run_digest(*arguments, context)
                                        : run_comparison(*arguments, context);
    };
  });
}

}  // namespace plait
