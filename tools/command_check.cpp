// plait check: says what is wrong with a mesh, and changes nothing.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "mesh/weld.h"
#include "plait/extend/attributed_mesh.h"
#include "report_json.h"
#include "report_text.h"

namespace plait {
namespace {

struct CheckArguments {
  std::filesystem::path mesh;
  std::optional<double> weld;
};

int run_check(const CheckArguments& arguments, const CommandContext& context) {
  const EndAtOnce end_at_once(context.json);
  std::vector<std::string> warnings;
  AttributedMesh mesh = read_attributed_mesh(arguments.mesh, &warnings, NotFinite::kKeep);
  std::uint64_t merged = 0;
  if (arguments.weld) merged = weld(mesh, *arguments.weld, arguments.mesh.native(), warnings);
  for (const std::string& warning : warnings) report_warning(warning);
  const Repaired repaired = repair(std::move(mesh.mesh), {}, arguments.mesh.native());
  const SurfaceFigures figures = figures_of(repaired.surface);
  if (context.json) {
    const nlohmann::ordered_json report = {
        {"mesh", arguments.mesh.string()},         {"merged_vertices", merged},
        {"seam_vertices", repaired.seam_vertices}, {"found", repairs_json(repaired.list)},
        {"repaired", figures_json(figures)},       {"seconds", seconds_since_start()}};
    print(json_text(report));
    return kExitDone;
  }
  const bool clean = repaired.list.is_clean();
  const std::string folded =
      figures.folded_edges == 0
          ? ""
          : fmt::format(
                "edges whose two faces lie on each other, with more than 175 degrees "
                "between their normals: {}\nsmall faces are turned over there, so "
                "remesh --no-foldover may refuse the mesh\n",
                format_count(figures.folded_edges));
  const std::string seams =
      repaired.seam_vertices == 0 ? "" : seam_text(repaired.seam_vertices) + "\n";
  print(fmt::format("{}: {}\n{}{}{}\n{}{}", arguments.mesh.native(),
                    clean ? "an oriented manifold"
                          : "not an oriented manifold as it is; remesh "
                            "would repair it:",
                    repair_text(repairs_json(repaired.list)),
                    clean ? "" : "then: ", figures_text(figures_json(figures)), seams, folded));
  return kExitDone;
}

}  // namespace

void add_check_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<CheckArguments>();
  CommandLine* command =
      program.add_subcommand("check", "Say what is wrong with a mesh, without changing it");
  command->add_option("MESH", arguments->mesh, "PLY, OBJ, OFF or STL, also .gz and .zst")
      ->required();
  add_weld_option(*command, arguments->weld);
  add_json_option(*command, context);
  command->footer(
      "The list is that of the repairs that remeshing does. A mesh that cannot be oriented, such "
      "as a\n"
      "Moebius strip, is refused with the place.\n"
      "\n"
      "Examples:\n"
      "  plait check scan.ply\n"
      "  plait check scan.ply --weld 1e-6\n"
      "  plait check scan.ply --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_check(*arguments, context); };
  });
}

}  // namespace plait
