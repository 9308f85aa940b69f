// plait layout: compares orders of the edges, and the windows that sweeps need with them; or makes
// a mesh in files, which is the job "layout".

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "job_command.h"
#include "json_text.h"
#include "measure.h"
#include "plait/job.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "span_diagram.h"
#include "store/new_output.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kRecordBytes = 12;  // a float32 position
constexpr int kWindowLevels = 5;

struct LayoutArguments {
  std::filesystem::path mesh, picture, out;
  std::string memory;
  std::string layout = "all";
  bool force = false;
};

struct Measured {
  LayoutKind kind;
  LayoutSpans spans;
  double seconds;
};

std::vector<LayoutKind> chosen_layouts(const std::string& name) {
  if (name != "all") return {layout_from_name(name)};
  return {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert, LayoutKind::kRcm};
}

/// With several layouts, the name of each picture contains the layout.
std::filesystem::path picture_path(const LayoutArguments& arguments, LayoutKind kind) {
  if (arguments.layout != "all") return arguments.picture;
  std::filesystem::path path = arguments.picture;
  path.replace_filename(
      fmt::format("{}-{}{}", path.stem().native(), to_string(kind), path.extension().native()));
  return path;
}

Json span_json(const StencilSpan& span) {
  return {
      {"span", span.span}, {"mean_width", span.mean_width}, {"median_width", span.median_width}};
}

Json layout_json(const BaseMesh& mesh, const LayoutArguments& arguments,
                 const std::vector<Measured>& layouts) {
  Json list = Json::array();
  for (const Measured& measured : layouts) {
    Json windows = Json::array();
    for (int level = 1; level <= kWindowLevels; ++level)
      windows.push_back(window_bytes(measured.spans.loop.span, level, kRecordBytes));
    list.push_back({{"layout", to_string(measured.kind)},
                    {"face", span_json(measured.spans.face)},
                    {"loop", span_json(measured.spans.loop)},
                    {"window_bytes", std::move(windows)},
                    {"seconds", measured.seconds}});
  }
  return {{"mesh", arguments.mesh.string()},
          {"vertices", mesh.vertex_count()},
          {"edges", mesh.edge_count()},
          {"faces", mesh.face_count()},
          {"border_edges", mesh.border_edge_count()},
          {"record_bytes", kRecordBytes},
          {"layouts", std::move(list)}};
}

void print_layout(const BaseMesh& mesh, const LayoutArguments& arguments,
                  const std::vector<Measured>& layouts) {
  print(fmt::format("{}: {} vertices, {} edges ({} border), {} faces\n\n", arguments.mesh.native(),
                    format_count(mesh.vertex_count()), format_count(mesh.edge_count()),
                    format_count(mesh.border_edge_count()), format_count(mesh.face_count())));
  print("          face stencils (3 edges)            Loop stencils (5 edges)\n");
  print("layout         span      mean    median        span      mean    median  seconds\n");
  for (const auto& [kind, spans, seconds] : layouts)
    print(fmt::format("{:<8} {:>10} {:>9.1f} {:>9}  {:>10} {:>9.1f} {:>9} {:>8.2f}\n",
                      to_string(kind), format_count(spans.face.span), spans.face.mean_width,
                      format_count(spans.face.median_width), format_count(spans.loop.span),
                      spans.loop.mean_width, format_count(spans.loop.median_width), seconds));
  print(fmt::format("\nwindow of positions ({} bytes each) for the Loop stencils, levels 1 to k\n",
                    kRecordBytes));
  print("layout  ");
  for (int level = 1; level <= kWindowLevels; ++level) print(fmt::format("       k = {}", level));
  print("\n");
  for (const Measured& measured : layouts) {
    print(fmt::format("{:<8}", to_string(measured.kind)));
    for (int level = 1; level <= kWindowLevels; ++level)
      print(fmt::format("{:>12}",
                        format_bytes(window_bytes(measured.spans.loop.span, level, kRecordBytes))));
    print("\n");
  }
}

BaseMesh read_with_warnings(const std::filesystem::path& path, const CommandContext& context) {
  const EndAtOnce nothing_is_made_yet(context.json);
  std::vector<std::string> warnings;
  BaseMesh mesh = read_base_mesh(path, &warnings);
  for (const std::string& warning : warnings) report_warning(warning);
  return mesh;
}

LaidOutMesh lay_out_or_end(const BaseMesh& mesh, LayoutKind kind, const CommandContext& context) {
  const EndAtOnce nothing_is_half_made(context.json);
  return lay_out(mesh, kind);
}

void check_usage(const LayoutArguments& arguments) {
  if (arguments.out.empty()) {
    if (!arguments.memory.empty())
      throw UsageError("--memory needs OUT: without it, all of the mesh is in memory");
    return;
  }
  if (!arguments.picture.empty() || arguments.force)
    throw UsageError(
        "expected OUT or --png and --force, found both: pictures are of meshes in memory");
  if (arguments.layout != "all" && arguments.layout != to_string(LayoutKind::kHilbert))
    throw UsageError(
        fmt::format("OUT has the layout hilbert, found --layout {}", arguments.layout));
}

int make_files(const LayoutArguments& arguments, const CommandContext& context) {
  JobOptions options = {{"mesh", arguments.mesh.native()}, {"out", arguments.out.native()}};
  if (!arguments.memory.empty()) options.emplace_back("memory", arguments.memory);
  const Json report = run_with_progress("layout", options, context);
  const auto count = [&](const char* name) {
    return format_count(report[name].get<std::uint64_t>());
  };
  print(context.json
            ? json_text(report)
            : fmt::format("{}: {} vertices, {} edges ({} border), {} faces, layout {}, "
                          "{:.2f} s\n",
                          report["base"].get<std::string>(), count("vertices"), count("edges"),
                          count("border_edges"), count("faces"),
                          report["layout"].get<std::string>(), report["seconds"].get<double>()));
  return kExitDone;
}

int run_layout(const LayoutArguments& arguments, const CommandContext& context) {
  if (!arguments.out.empty()) return make_files(arguments, context);
  const std::vector<LayoutKind> kinds = chosen_layouts(arguments.layout);
  if (!arguments.picture.empty()) require_extension("draw", arguments.picture, ".png");
  const Existing existing = arguments.force ? Existing::kReplace : Existing::kRefuse;
  if (!arguments.picture.empty())
    for (const LayoutKind kind : kinds)
      UnpublishedFile::check(picture_path(arguments, kind), existing);
  const BaseMesh mesh = read_with_warnings(arguments.mesh, context);
  std::vector<Measured> layouts;
  for (const LayoutKind kind : kinds) {
    const Stopwatch clock;
    const LaidOutMesh laid_out = lay_out_or_end(mesh, kind, context);
    layouts.push_back({laid_out.kind, laid_out.spans, clock.seconds()});
    if (arguments.picture.empty()) continue;
    const std::filesystem::path path = picture_path(arguments, laid_out.kind);
    make_new_file(path, existing, report_warning, [&](UnpublishedFile& output) {
      draw_span_diagram(laid_out.mesh, output.file());
    });
  }
  if (context.json)
    print(json_text(layout_json(mesh, arguments, layouts)));
  else
    print_layout(mesh, arguments, layouts);
  return kExitDone;
}

}  // namespace

void add_layout_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<LayoutArguments>();
  CommandLine* command = program.add_subcommand(
      "layout",
      "Compare orders of the edges and their windows, or order a mesh larger than memory");
  command->add_option("MESH", arguments->mesh, "PLY, OBJ or OFF, also .gz and .zst")->required();
  const JobDescription& job = find_job("layout");
  command->add_option("OUT", arguments->out, job.options.at(1).help + "; hilbert, from a PLY file");
  const JobOption& memory = job.options.at(2);
  command
      ->add_parsed_option(
          "--memory",
          [arguments, &memory](const std::string& text) {
            check_option(memory, text);
            arguments->memory = text;
          },
          "With OUT: " + memory.help)
      ->type_name(memory.value_name)
      ->default_str(*memory.default_text);
  command
      ->add_option("--layout", arguments->layout,
                   "given, spatial, hilbert, rcm, auto (the best of them) or all")
      ->capture_default_str();
  add_output_option(*command, "--png", arguments->picture,
                    "Draw the span diagram; with several layouts, one NAME-LAYOUT.png for each");
  command->add_flag("--force", arguments->force, "Replace pictures that exist");
  add_json_option(*command, context);
  command->footer(
      "The width of a stencil is the difference of its largest and smallest edge index. The span\n"
      "is the largest width. A window has the slots of 2 x span edges on every level.\n"
      "\n"
      "With OUT the mesh, which may be larger than memory, is put in the order hilbert by sorts\n"
      "of files. plait subdivide and plait plan take OUT as their mesh: a store of it has the "
      "same\n"
      "bytes as one of MESH with --layout hilbert. The sorts need disk beside OUT, about 230 "
      "bytes\n"
      "for each face: that is said before, and refused if less is free.\n"
      "\n"
      "Examples:\n"
      "  plait layout molecule.ply\n"
      "  plait layout statue.ply statue.base --memory 2G\n"
      "  plait layout molecule.ply --layout rcm --png spans.png");
  command->callback([arguments, &context] {
    check_usage(*arguments);
    context.run = [arguments, &context] { return run_layout(*arguments, context); };
  });
}

}  // namespace plait
