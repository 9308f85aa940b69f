// plait export: writes one level of a store as a mesh file.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "argument_text.h"
#include "base/text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string export_text(const nlohmann::ordered_json& report) {
  const auto count = [&](const char* name) {
    return format_count(report[name].get<std::uint64_t>());
  };
  std::string lost;
  if (const auto error = report["position_error"].get<double>(); error > 0)
    lost = fmt::format(
        ", {} {} have coordinates that are off, by at most {} (.ply, .obj and .vtp files keep "
        "them)",
        count("moved"),
        report["file"].get<std::string>().ends_with("stl") ? "triangles" : "vertices", error);
  if (report["side_normals"].get<std::uint64_t>() > 0)
    lost += fmt::format(", {} normals at sharp edges are those of one side", count("side_normals"));
  if (!report["left_out"].empty())
    lost += fmt::format(", without {}",
                        fmt::join(report["left_out"].get<std::vector<std::string>>(), ", "));
  return fmt::format("{}: level {}, {} patches, {} vertices, {} triangles, {}{}, {:.2f} s\n",
                     report["file"].get<std::string>(), report["level"].get<int>(),
                     count("patches"), count("vertices"), count("faces"),
                     format_bytes(report["file_bytes"].get<std::uint64_t>()), lost,
                     report["seconds"].get<double>());
}

}  // namespace

void add_export_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {"export",
       "The command needs only the memory of its budget, for any level. The file has base "
       "vertices\n"
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
       "         Normals have length 1; positions of float64 are relative to the node's "
       "translation\n"
       "  .gltf  the same with the numbers in a .bin beside it\n"
       "A patch is part of a box if the box meets the bounds of the patch (plait bounds).\n"
       "\n"
       "Examples:\n"
       "  plait export surface.plait surface.ply --attribute normal\n"
       "  plait export surface.plait coarse.obj.gz --level 2\n"
       "  plait export surface.plait part.vtp --box 0,0,0,1,1,1 --attribute normal\n"
       "  plait export surface.plait web.glb --level 3 --attribute normal --quantize",
       export_text});
}

}  // namespace plait
