// plait export: writes one level of a store as a mesh file.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "console.h"
#include "export/mesh_export.h"
#include "export/output_files.h"
#include "export/part_text.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/store.h"
#include "progress.h"

namespace plait {
namespace {

struct ExportArguments {
  std::filesystem::path store, output;
  int level = -1;
  ExportOptions options;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
};

int run_export(const ExportArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  ExportOptions options = arguments.options;
  options.format = export_format(arguments.output);
  OutputFiles output(arguments.output);
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, context.open_backends);
  options.level = arguments.level >= 0
                      ? arguments.level
                      : store.attributes()[store.attribute("position")].finest_level;
  ExportResult result;
  try {
    ProgressBar progress("export", ProgressUnit::kNone);
    options.progress = [&](const Progress& now) { return progress.update(now.done, now.total); };
    result = export_mesh(store, output, options);
  } catch (const Error& error) {
    throw output.named(error);
  }
  throw_if_interrupted();
  output.publish();

  if (!context.json) {
    std::string moved;
    if (options.quantize)
      moved = fmt::format(", coordinates off by at most {}", result.position_error);
    print(fmt::format("{}: level {}, {} patches, {} vertices, {} triangles, {}{}, {:.2f} s\n",
                      output.path().native(), options.level, format_count(result.patches),
                      format_count(result.vertices), format_count(result.triangles),
                      format_bytes(result.file_bytes), moved, clock.seconds()));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {{"store", arguments.store.string()},
                                         {"file", output.path().string()},
                                         {"level", options.level},
                                         {"patches", result.patches},
                                         {"vertices", result.vertices},
                                         {"faces", result.triangles},
                                         {"file_bytes", result.file_bytes},
                                         {"position_error", result.position_error},
                                         {"seconds", clock.seconds()}};
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_export_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ExportArguments>();
  CommandLine* command =
      program.add_subcommand("export", "Write one level of a store as a mesh file");
  command->add_option("STORE", arguments->store, "The store")->required();
  add_output_option(*command, "OUT", arguments->output,
                    "The file to make, or to replace: NAME.(ply|obj|stl|off)[.gz|.zst], "
                    "NAME.(vtp|pvtp|glb|gltf)")
      ->required();
  add_level_option(*command, arguments->level, "The level; default: the finest");
  ExportOptions& options = arguments->options;
  command
      ->add_option(
          "--attribute", options.attributes,
          "Also write this attribute, such as normal; for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option(
          "--face-attribute", options.face_attributes,
          "Also write this attribute of the base faces as one of the triangles (PLY and VTK "
          "only); for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_parsed_option(
          "--box", [&options](const std::string& text) { options.box = parse_box(text); },
          "Only patches that reach into this box")
      ->type_name("X,Y,Z,X,Y,Z");
  command
      ->add_parsed_option(
          "--faces", [&options](const std::string& text) { options.faces = parse_faces(text); },
          "Only the patches of these base faces, such as 0,7,20-29")
      ->type_name("LIST");
  command->add_flag("--quantize", options.quantize,
                    "glTF: coordinates in 16 bits and normals in 8 (KHR_mesh_quantization)");
  add_whole_option(*command, "--pieces", options.pieces, 1, 64,
                   "PVTP: the number of .vtp files; default: one for 4 million triangles");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The command needs only the memory of its budget, for any level. The file has base vertices\n"
      "first, then vertices by level in slot order, then triangles. Vertices of a coarser level\n"
      "have the positions that the finest level gives them.\n"
      "  .ply   binary, with every attribute but 64-bit integers: normal as nx ny nz, color as "
      "red\n"
      "         green blue alpha, texture as s t, others as NAME or NAME_0 NAME_1 ...; plait "
      "import\n"
      "         reads them back\n"
      "  .obj   can have normals      .stl .off   positions only\n"
      "  .vtp   VTK and ParaView, with every attribute; .pvtp names several .vtp beside it\n"
      "  .glb   glTF, up to 2 GiB: patches share their indices, and each has its own vertices.\n"
      "         NORMAL, COLOR_0, TEXCOORD_0, others of 8 and 16 bits and float32 as _NAME.\n"
      "  .gltf  the same with the numbers in a .bin beside it\n"
      "A patch is part of a box if the box meets the bounds of the patch (plait bounds).\n"
      "\n"
      "Examples:\n"
      "  plait export surface.plait surface.ply --attribute normal\n"
      "  plait export surface.plait coarse.obj.gz --level 2\n"
      "  plait export surface.plait part.vtp --box 0,0,0,1,1,1 --attribute normal\n"
      "  plait export surface.plait web.glb --level 3 --attribute normal --quantize");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_export(*arguments, context); };
  });
}

}  // namespace plait
