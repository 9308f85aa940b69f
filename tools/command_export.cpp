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
#include "export/export_mesh.h"
#include "export/part_text.h"
#include "interrupt.h"
#include "measure.h"
#include "plait/store.h"
#include "progress.h"

namespace plait {
namespace {

/// Draws a progress bar, and lets a signal cancel the job.
ExportResult run_job(const ExportRequest& request, const CommandContext& context) {
  ProgressBar progress("export", ProgressUnit::kNone);
  return export_mesh(
      request, context.open_backends,
      {.progress = [&](const Progress& now) { return progress.update(now.done, now.total); },
       .warn =
           [&](const std::string& warning) {
             progress.clear();
             report_warning(warning);
           },
       .before_publish = throw_if_interrupted});
}

int run_export(const ExportRequest& request, const CommandContext& context) {
  const Stopwatch clock;
  const ExportResult done = run_job(request, context);
  if (!context.json) {
    std::string moved;
    if (request.quantize)
      moved = fmt::format(", coordinates off by at most {}", done.position_error);
    print(fmt::format("{}: level {}, {} patches, {} vertices, {} triangles, {}{}, {:.2f} s\n",
                      done.file.native(), done.level, format_count(done.patches),
                      format_count(done.vertices), format_count(done.triangles),
                      format_bytes(done.file_bytes), moved, clock.seconds()));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {{"store", request.store.string()},
                                         {"file", done.file.string()},
                                         {"level", done.level},
                                         {"patches", done.patches},
                                         {"vertices", done.vertices},
                                         {"faces", done.triangles},
                                         {"file_bytes", done.file_bytes},
                                         {"position_error", done.position_error},
                                         {"seconds", clock.seconds()}};
  print(report.dump(2) + "\n");
  return kExitDone;
}

}  // namespace

void add_export_command(CommandLine& program, CommandContext& context) {
  const auto request = std::make_shared<ExportRequest>();
  CommandLine* command =
      program.add_subcommand("export", "Write one level of a store as a mesh file");
  command->add_option("STORE", request->store, "The store")->required();
  add_output_option(*command, "OUT", request->output,
                    "The file to make, or to replace: NAME.(ply|obj|stl|off)[.gz|.zst], "
                    "NAME.(vtp|pvtp|glb|gltf)")
      ->required();
  add_level_option(*command, request->level, "The level; default: the finest");
  command
      ->add_option(
          "--attribute", request->attributes,
          "Also write this attribute, such as normal; for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option(
          "--face-attribute", request->face_attributes,
          "Also write this attribute of the base faces as one of the triangles (PLY and VTK "
          "only); for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_parsed_option(
          "--box",
          [request = request.get()](const std::string& text) { request->box = parse_box(text); },
          "Only patches that reach into this box")
      ->type_name("X,Y,Z,X,Y,Z");
  command
      ->add_parsed_option(
          "--faces",
          [request = request.get()](const std::string& text) {
            request->faces = parse_faces(text);
          },
          "Only the patches of these base faces, such as 0,7,20-29")
      ->type_name("LIST");
  command->add_flag("--quantize", request->quantize,
                    "glTF: coordinates in 16 bits and normals in 8 (KHR_mesh_quantization)");
  add_whole_option(*command, "--pieces", request->pieces, 1, 64,
                   "PVTP: the number of .vtp files; default: one for 4 million triangles");
  add_size_option(*command, "--memory", request->budget_bytes, "Budget for blocks in memory");
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
  command->callback([request, &context] {
    context.run = [request, &context] { return run_export(*request, context); };
  });
}

}  // namespace plait
