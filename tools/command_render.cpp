// plait render: draws a picture of a store, patch by patch.

#include <fmt/format.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "argument_text.h"
#include "job_command.h"

namespace plait {
namespace {

std::string render_text(const nlohmann::ordered_json& report) {
  return fmt::format(
      "{}: {} x {} pixels, level {}, {} triangles, {:.2f} s\n", report["file"].get<std::string>(),
      report["width"].get<int>(), report["height"].get<int>(), report["level"].get<int>(),
      format_count(report["triangles"].get<std::uint64_t>()), report["seconds"].get<double>());
}

}  // namespace

void add_render_command(CommandLine& program, CommandContext& context) {
  add_job_command(
      program, context,
      {.job = "render",
       .footer =
           "The shading uses the normals of the store, or computes them from the triangles if the "
           "store\n"
           "has none. The command needs the budget and 48 bytes per pixel of memory, for any "
           "level; "
           "with\n"
           "--color-by 56 bytes.\n"
           "\n"
           "Examples:\n"
           "  plait render surface.plait surface.png\n"
           "  plait render surface.plait back.png --size 1920x1080 --view 200,15 --up z --level 3\n"
           "  plait render scan.plait distance.png --color-by distance",
       .text = render_text});
}

}  // namespace plait
