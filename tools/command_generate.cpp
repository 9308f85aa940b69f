// plait generate: makes a base mesh from a seed.

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "generate/generate.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/mesh_io.h"
#include "progress.h"
#include "store/new_output.h"

namespace plait {
namespace {

struct GenerateArguments {
  std::string kind;
  std::filesystem::path output;
  std::uint64_t vertices = 26016, seed = 1;
  bool force = false;
};

IndexedMesh generate_with_progress(GeneratorKind kind, const GenerateArguments& arguments,
                                   const CommandContext& context) {
  const EndAtOnce nothing_is_made_yet(context.json);
  ProgressBar progress("generate", ProgressUnit::kNone);
  constexpr std::uint64_t kSteps = 1000;
  return generate(kind, arguments.vertices, arguments.seed, [&](double fraction) {
    progress.update(static_cast<std::uint64_t>(fraction * kSteps), kSteps);
  });
}

int run_generate(const GenerateArguments& arguments, const CommandContext& context) {
  const GeneratorKind kind = generator_from_name(arguments.kind);
  require_extension("generate", arguments.output, ".ply");
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  const Stopwatch clock;
  IndexedMesh mesh;
  const std::filesystem::path made =
      make_new_file(arguments.output, existing, report_warning, [&](UnpublishedFile& output) {
        mesh = generate_with_progress(kind, arguments, context);
        write_ply(output.file(), mesh);
        throw_if_interrupted();
      });

  if (context.json) {
    const nlohmann::ordered_json report = {
        {"kind", to_string(kind)},    {"file", made.string()},  {"vertices", mesh.positions.size()},
        {"faces", mesh.faces.size()}, {"seed", arguments.seed}, {"seconds", clock.seconds()}};
    print(json_text(report));
  } else {
    print(fmt::format("{}: {}, {} vertices, {} faces, seed {}, {:.2f} s\n", made.native(),
                      to_string(kind), format_count(mesh.positions.size()),
                      format_count(mesh.faces.size()), arguments.seed, clock.seconds()));
  }
  return kExitDone;
}

}  // namespace

void add_generate_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<GenerateArguments>();
  CommandLine* command = program.add_subcommand("generate", "Make a base mesh from a seed");
  command->add_option("KIND", arguments->kind, "molecule, torus, icosphere or open-sheet")
      ->required();
  add_output_option(*command, "OUT", arguments->output, "The file to make: NAME.ply")->required();
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  add_whole_option(*command, "--vertices", arguments->vertices, 0, kLargest,
                   "The exact number of vertices")
      ->default_str(std::to_string(arguments->vertices));
  add_whole_option(*command, "--seed", arguments->seed, 0, kLargest, "Each seed gives another mesh")
      ->default_str(std::to_string(arguments->seed));
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
    context.run = [arguments, &context] { return run_generate(*arguments, context); };
  });
}

}  // namespace plait
