// plait bench floors: what disks can do without plait.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "command.h"
#include "command_bench.h"
#include "console.h"
#include "instrument/disk.h"
#include "instrument/environment.h"
#include "instrument/scratch_directory.h"
#include "interrupt.h"
#include "json_text.h"
#include "runs/floors.h"

namespace plait {
namespace {

struct BenchFloorsArguments {
  std::vector<std::filesystem::path> directories;
  std::uint64_t floor_bytes = 256u << 20, block_bytes = 1u << 20;
  bool no_fio = false;
};

int run_floors(const BenchFloorsArguments& arguments, const CommandContext& context) {
  std::vector<std::filesystem::path> directories = arguments.directories;
  if (directories.empty()) directories = {"."};
  std::vector<nlohmann::ordered_json> floors;
  for (const std::filesystem::path& directory : directories) {
    instrument::require_space(directory, 2 * arguments.floor_bytes);
    const instrument::ScratchDirectory scratch(directory);
    for (nlohmann::ordered_json& floor :
         bench::measure_floors(scratch.path(), arguments.floor_bytes, arguments.block_bytes,
                               !arguments.no_fio, [] { throw_if_interrupted(); })) {
      floor["directory"] = directory.native();
      floors.push_back(std::move(floor));
    }
  }
  print(context.json ? json_text(nlohmann::ordered_json{
                           {"command", command_text()},
                           {"date", instrument::date_text()},
                           {"environment",
                            instrument::environment(instrument::disk_facts(directories.front()))},
                           {"floors", floors}})
                     : bench::floor_table(floors));
  return kExitDone;
}

}  // namespace

void add_bench_floors_command(CommandLine& bench, CommandContext& context) {
  const auto arguments = std::make_shared<BenchFloorsArguments>();
  CommandLine* command = bench.add_subcommand("floors", "Measure what disks can do without plait");
  command->add_option("DIR", arguments->directories, "Directories; default: the working one");
  add_size_option(*command, "--bytes", arguments->floor_bytes, "To move; default 256MiB");
  add_size_option(*command, "--block", arguments->block_bytes, "Unit of I/O; default 1MiB");
  command->add_flag("--no-fio", arguments->no_fio, "Only by our own program");
  add_json_option(*command, context);
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_floors(*arguments, context); };
  });
}

}  // namespace plait
