// plait bounds: writes the file of bounds, with which readers find patches in a box or along a ray.

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
#include "plait/bounds.h"
#include "plait/store.h"
#include "progress.h"

namespace plait {
namespace {

struct BoundsArguments {
  std::filesystem::path store;
  std::string attribute = "position";
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
};

int run_bounds(const BoundsArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  const Store store = Store::open(arguments.store, open, context.open_backends);
  ProgressBar progress("bounds", ProgressUnit::kBytes);
  write_bounds(store, arguments.attribute,
               [&](const Progress& now) { return progress.update(now.done, now.total); });
  progress.clear();
  const std::uint64_t faces = store.base().face_count();
  if (context.json) {
    const nlohmann::ordered_json report = {{"store", arguments.store.string()},
                                           {"attribute", arguments.attribute},
                                           {"faces", faces},
                                           {"seconds", clock.seconds()}};
    print(json_text(report));
  } else {
    print(fmt::format("{}: bounds of '{}' of {} patches, {:.2f} s\n", arguments.store.native(),
                      arguments.attribute, format_count(faces), clock.seconds()));
  }
  return kExitDone;
}

}  // namespace

void add_bounds_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<BoundsArguments>();
  CommandLine* command =
      program.add_subcommand("bounds", "Write where the patches of a store are, for its readers");
  command->add_option("STORE", arguments->store, "The store")->required();
  command
      ->add_option("--attribute", arguments->attribute,
                   "Positions: three float32 or float64 numbers")
      ->capture_default_str();
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Reads all levels of the attribute once, and writes the smallest box that contains each "
      "patch\n"
      "to a file of the store. Programs that look for patches in a box or along a ray then read\n"
      "this file, and not the levels. After a commit that changes the attribute they no longer\n"
      "use the file, until this command is run again.\n"
      "\n"
      "Examples:\n"
      "  plait bounds surface.plait\n"
      "  plait bounds surface.plait --attribute smoothed --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_bounds(*arguments, context); };
  });
}

}  // namespace plait
