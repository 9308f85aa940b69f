// The job "render".
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "conversion/read_back.h"
#include "job.h"
#include "picture/color_map.h"
#include "picture/png_file.h"
#include "plait/base_mesh.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/store.h"
#include "render/shading.h"
#include "render/surface.h"
#include "store/new_output.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct RenderArguments {
  std::filesystem::path store, output;
  std::optional<int> level;
  PictureSize size{1600, 1200};
  ViewAngles view{35, 20};
  UpAxis up = UpAxis::kY;
  std::string color_by;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
  int threads = 1;
  Existing existing = Existing::kRefuse;
};

struct Drawn {
  Image image;
  ColorBy color_by;
};

ColorBy color_scale(Store& store, int level, const std::string& name) {
  if (name == "depth" && store.has_depths() && !store.has_attribute(name)) {
    const FaceDepths& depths = *store.base().depths();
    const auto level_of = [&](int depth) {
      return static_cast<double>(std::min(level, store.base_level() + depth));
    };
    return {name, {level_of(depths.shallowest()), level_of(depths.deepest())}, true};
  }
  return {name, name.empty() ? ScalarRange{} : scalar_range(store, name, level), false};
}

Drawn draw(Store& store, int level, const RenderArguments& arguments, const JobCall& call) {
  const ColorBy color_by = color_scale(store, level, arguments.color_by);
  const bool colored = !color_by.attribute.empty();
  const PictureSize size = arguments.size;
  SampleBuffer samples(size.width * kSamplesPerSide, size.height * kSamplesPerSide, colored);
  const std::size_t legend = colored ? legend_height(static_cast<std::size_t>(size.width),
                                                     static_cast<std::size_t>(size.height))
                                     : 0;
  const Camera camera =
      fitting_camera(store, level, arguments.view, arguments.up, samples.width(),
                     samples.height() - kSamplesPerSide * static_cast<int>(legend));
  const ProgressCallback progress = begin_step(call.watch, "render");
  draw_surface(store, level, camera, samples, progress, color_by);
  const auto faces = static_cast<std::uint64_t>(store.base().face_count());
  const auto report = [&] {
    if (progress && !progress({"shading", faces, faces}))
      throw Error(ErrorCode::kCancelled, "render: cancelled");
  };
  Image image = shade(samples, camera, {call.parallel_for, arguments.threads, report});
  if (colored) draw_legend(image, {color_by.attribute, color_by.range.low, color_by.range.high});
  return {std::move(image), color_by};
}

JobReport run_render(const RenderArguments& arguments, const JobCall& call) {
  require_extension("render to", arguments.output, ".png");
  UnpublishedFile::check(arguments.output, arguments.existing);
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, call.open_backends);
  const int level =
      arguments.level.value_or(store.attributes()[store.attribute("position")].finest_level);
  ColorBy color_by;
  const std::filesystem::path made = make_new_file(
      arguments.output, arguments.existing, call.watch.warn, [&](UnpublishedFile& output) {
        Drawn drawn = draw(store, level, arguments, call);
        color_by = std::move(drawn.color_by);
        if (call.watch.before_files) call.watch.before_files();
        write_png(drawn.image, output.file());
      });
  JobReport report = {
      {"store", arguments.store.string()},
      {"file", made.string()},
      {"width", arguments.size.width},
      {"height", arguments.size.height},
      {"level", level},
      {"triangles",
       counts_at_level(store.base(), relative_to_base(level, store.base_level()).refinements)
           .faces}};
  if (!color_by.attribute.empty())
    report["color_by"] = {{"attribute", color_by.attribute},
                          {"low", color_by.range.low},
                          {"high", color_by.range.high}};
  return report;
}

}  // namespace

Job render_job() {
  JobTable<RenderArguments> table("render", "Draw one level of a store as a PNG");
  table.path("store", &RenderArguments::store, "The store").at(0).required();
  table.output("out", &RenderArguments::output, "The file to make: NAME.png").at(1).required();
  table.count("level", &RenderArguments::level, 0, kMaxLevel, "The level; default: the finest");
  table
      .named(
          "size",
          [](RenderArguments& arguments, const std::string& text) {
            arguments.size = parse_picture_size(text);
          },
          "Pixels, each number at most 8192")
      .shown_as("WIDTHxHEIGHT")
      .by_default("1600x1200");
  table
      .named(
          "view",
          [](RenderArguments& arguments, const std::string& text) {
            arguments.view = parse_view(text);
          },
          "Degrees around the up axis, and above the horizon")
      .shown_as("AZIMUTH,ELEVATION")
      .by_default("35,20");
  table
      .choice(
          "up", {"x", "y", "z"},
          [](RenderArguments& arguments, const std::string& name) {
            arguments.up = name == "x" ? UpAxis::kX : name == "y" ? UpAxis::kY : UpAxis::kZ;
          },
          "The axis that points up")
      .by_default("y");
  table.text(
      "color-by", &RenderArguments::color_by,
      "Colour the surface by an attribute of one number, with a legend; depth: by the depths "
      "of faces, where they have depths of their own");
  table.bytes("memory", &RenderArguments::memory_bytes, "Budget for blocks in memory");
  table.threads(&RenderArguments::threads, "Threads of the shading");
  table.force(&RenderArguments::existing, "Replace OUT if it exists", "replaces a file");
  return table.run(run_render);
}

PLAIT_END_NAMESPACE
