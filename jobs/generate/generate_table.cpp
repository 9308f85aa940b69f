// The job "generate".
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>

#include "generate/generate.h"
#include "job.h"
#include "plait/error.h"
#include "plait/mesh_io.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct GenerateArguments {
  GeneratorKind kind = GeneratorKind::kMolecule;
  std::filesystem::path output;
  std::uint64_t vertices = 26016, seed = 1;
  Existing existing = Existing::kRefuse;
};

JobReport run_generate(const GenerateArguments& arguments, const JobCall& call) {
  require_extension("generate", arguments.output, ".ply");
  const auto report = [&](double fraction) {
    constexpr std::uint64_t kSteps = 1000;
    const auto done = static_cast<std::uint64_t>(fraction * kSteps);
    if (call.watch.progress && !call.watch.progress({"generate", done, kSteps}))
      throw Error(ErrorCode::kCancelled, "generate: cancelled");
  };
  IndexedMesh mesh;
  const std::filesystem::path made = make_new_file(
      arguments.output, arguments.existing, call.watch.warn, [&](UnpublishedFile& output) {
        if (call.watch.step) call.watch.step("generate");
        mesh = generate(arguments.kind, arguments.vertices, arguments.seed, report);
        if (call.watch.before_files) call.watch.before_files();
        write_ply(output.file(), mesh);
        report(1);
      });
  return {{"kind", to_string(arguments.kind)},
          {"file", made.string()},
          {"vertices", mesh.positions.size()},
          {"faces", mesh.faces.size()},
          {"seed", arguments.seed}};
}

}  // namespace

Job generate_job() {
  JobTable<GenerateArguments> table("generate", "Make a base mesh from a seed");
  table
      .choice(
          "kind", {"molecule", "torus", "icosphere", "open-sheet"},
          [](GenerateArguments& arguments, const std::string& name) {
            arguments.kind = generator_from_name(name);
          },
          "The surface")
      .at(0)
      .required();
  table.output("out", &GenerateArguments::output, "The file to make: NAME.ply").at(1).required();
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  table.count("vertices", &GenerateArguments::vertices, 0, kLargest,
              "The exact number of vertices");
  table.count("seed", &GenerateArguments::seed, 0, kLargest, "Each seed gives another mesh");
  table.force(&GenerateArguments::existing, "Replace OUT if it exists", "replaces a file");
  return table.run(run_generate);
}

PLAIT_END_NAMESPACE
