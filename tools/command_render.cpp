// plait render: draws a picture of a store, patch by patch.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "arguments.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "picture/color_map.h"
#include "picture/png_file.h"
#include "plait/store.h"
#include "progress.h"
#include "render/shading.h"
#include "render/surface.h"
#include "store/new_output.h"

namespace plait {
namespace {

struct RenderArguments {
  std::filesystem::path store, output;
  int level = -1;
  std::string size = "1600x1200", view = "35,20", up = "y";
  std::string color_by;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
  int threads = default_thread_count();
};

UpAxis axis_from_name(std::string_view name) {
  return name == "x" ? UpAxis::kX : name == "y" ? UpAxis::kY : UpAxis::kZ;
}

int run_render(const RenderArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  const PictureSize size = parse_picture_size(arguments.size);
  const ViewAngles view = parse_view(arguments.view);
  require_extension("render to", arguments.output, ".png");
  UnpublishedFile::check(arguments.output, Existing::kReplace);
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, context.open_backends);
  const int level = arguments.level >= 0
                        ? arguments.level
                        : store.attributes()[store.attribute("position")].finest_level;

  ColorBy color_by{arguments.color_by, {}};
  const bool colored = !color_by.attribute.empty();
  if (colored) color_by.range = scalar_range(store, color_by.attribute, level);
  SampleBuffer samples(size.width * kSamplesPerSide, size.height * kSamplesPerSide, colored);
  const std::size_t legend = colored ? legend_height(static_cast<std::size_t>(size.width),
                                                     static_cast<std::size_t>(size.height))
                                     : 0;
  const Camera camera =
      fitting_camera(store, level, view, axis_from_name(arguments.up), samples.width(),
                     samples.height() - kSamplesPerSide * static_cast<int>(legend));
  {
    ProgressBar progress("render", ProgressUnit::kNone);
    draw_surface(
        store, level, camera, samples,
        [&](const Progress& now) { return progress.update(now.done, now.total); }, color_by);
  }
  Image image = [&] {
    const EndAtOnce nothing_is_made_yet(context.json);
    return shade(samples, camera, arguments.threads);
  }();
  if (colored) draw_legend(image, {color_by.attribute, color_by.range.low, color_by.range.high});
  const std::filesystem::path made = make_new_file(arguments.output, Existing::kReplace,
                                                   report_warning, [&](UnpublishedFile& output) {
                                                     write_png(image, output.file());
                                                     throw_if_interrupted();
                                                   });

  const std::uint64_t triangles = store.base().face_count()
                                  << (2 * relative_to_base(level, store.base_level()).refinements);
  if (!context.json) {
    print(fmt::format("{}: {} x {} pixels, level {}, {} triangles, {:.2f} s\n", made.native(),
                      size.width, size.height, level, format_count(triangles), clock.seconds()));
    return kExitDone;
  }
  nlohmann::ordered_json report = {{"store", arguments.store.string()},
                                   {"file", made.string()},
                                   {"width", size.width},
                                   {"height", size.height},
                                   {"level", level},
                                   {"triangles", triangles},
                                   {"peak_rss_bytes", peak_rss_bytes()},
                                   {"seconds", clock.seconds()}};
  if (colored)
    report["color_by"] = {{"attribute", color_by.attribute},
                          {"low", color_by.range.low},
                          {"high", color_by.range.high}};
  print(json_text(report));
  return kExitDone;
}

}  // namespace

void add_render_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<RenderArguments>();
  CommandLine* command = program.add_subcommand("render", "Draw one level of a store as a PNG");
  command->add_option("STORE", arguments->store, "The store")->required();
  add_output_option(*command, "OUT", arguments->output, "The file to make, or to replace: NAME.png")
      ->required();
  add_level_option(*command, arguments->level, "The level; default: the finest");
  command->add_option("--size", arguments->size, "WIDTHxHEIGHT in pixels, each at most 8192")
      ->capture_default_str();
  command
      ->add_option("--view", arguments->view,
                   "AZIMUTH,ELEVATION in degrees: around the up axis, and above the horizon")
      ->capture_default_str();
  command->add_option("--up", arguments->up, "The axis that points up: x, y or z")
      ->one_of({"x", "y", "z"})
      ->type_name("AXIS")
      ->capture_default_str();
  command->add_option("--color-by", arguments->color_by,
                      "Colour the surface by an attribute of one number, with a legend");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_threads_option(*command, arguments->threads, "Threads of the shading");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The shading uses the normals of the store, or computes them from the triangles if the "
      "store\n"
      "has none. The command needs the budget and 48 bytes per pixel of memory, for any level; "
      "with\n"
      "--color-by 56 bytes.\n"
      "\n"
      "Examples:\n"
      "  plait render surface.plait surface.png\n"
      "  plait render surface.plait back.png --size 1920x1080 --view 200,15 --up z --level 3\n"
      "  plait render scan.plait distance.png --color-by distance");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_render(*arguments, context); };
  });
}

}  // namespace plait
