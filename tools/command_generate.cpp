// plait generate: a base mesh from a seed.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "generate/generate.h"
#include "interrupt.h"
#include "measure.h"
#include "partial_output.h"
#include "plait/mesh_io.h"
#include "progress.h"

namespace plait {
namespace {

struct Arguments {
  std::string kind;
  std::filesystem::path output;
  std::uint64_t vertices = 26016, seed = 1;
  bool force = false;
};

int run(const Arguments& arguments, const CommandContext& context) {
  const GeneratorKind kind = generator_from_name(arguments.kind);
  if (arguments.output.extension() != ".ply")
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("generate {}: expected a name that ends in .ply", arguments.output.native()));
  PartialOutput output(arguments.output,
                       arguments.force ? Existing::kReplaceFile : Existing::kRefuse);
  const Stopwatch clock;
  Progress progress("generate", ProgressUnit::kNone);
  constexpr std::uint64_t kSteps = 1000;
  const IndexedMesh mesh = generate(kind, arguments.vertices, arguments.seed, [&](double fraction) {
    progress.update(static_cast<std::uint64_t>(fraction * kSteps), kSteps);
    throw_if_interrupted();
  });
  write_ply(output.path(), mesh);
  throw_if_interrupted();
  output.publish(false);
  progress.clear();

  if (context.json) {
    const nlohmann::ordered_json report = {{"kind", to_string(kind)},
                                           {"file", output.final_path().string()},
                                           {"vertices", mesh.positions.size()},
                                           {"faces", mesh.faces.size()},
                                           {"seed", arguments.seed},
                                           {"seconds", clock.seconds()}};
    print(report.dump(2) + "\n");
  } else {
    print(fmt::format("{}: {}, {} vertices, {} faces, seed {}, {:.2f} s\n",
                      output.final_path().native(), to_string(kind),
                      format_count(mesh.positions.size()), format_count(mesh.faces.size()),
                      arguments.seed, clock.seconds()));
  }
  return kExitDone;
}

}  // namespace

void add_generate_command(CLI::App& program, CommandContext& context) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand("generate", "Make a base mesh from a seed");
  command->add_option("KIND", arguments->kind, "molecule, torus, icosphere or open-sheet")
      ->required();
  command->add_option("OUT", arguments->output, "The file to make: NAME.ply")->required();
  command->add_option("--vertices", arguments->vertices, "Exactly so many vertices")
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Another seed, another mesh")
      ->capture_default_str();
  command->add_flag("--force", arguments->force, "Replace OUT if it exists");
  add_json_option(*command, context);
  command->footer(
      "molecule, torus and icosphere are closed, open-sheet has a border. The same kind, count\n"
      "and seed give the same file.\n"
      "\n"
      "Examples:\n"
      "  plait generate molecule molecule.ply --vertices 26016 --seed 1\n"
      "  plait generate open-sheet sheet.ply --vertices 5000 --force");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run(*arguments, context); };
  });
}

}  // namespace plait
