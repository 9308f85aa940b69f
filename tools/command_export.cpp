// plait export: writes one level of a store as a mesh file.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "console.h"
#include "export/mesh_export.h"
#include "interrupt.h"
#include "io/partial_output.h"
#include "measure.h"
#include "plait/store.h"
#include "progress.h"
#include "store/left_overs.h"

namespace plait {
namespace {

struct ExportArguments {
  std::filesystem::path store, output;
  int level = -1;
  std::vector<std::string> attributes, face_attributes;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
};

int run_export(const ExportArguments& arguments, const CommandContext& context) {
  const Stopwatch clock;
  ExportOptions options;
  options.format = export_format(arguments.output);
  options.attributes = arguments.attributes;
  options.face_attributes = arguments.face_attributes;
  PartialFile::check(arguments.output, Existing::kReplace);
  remove_left_overs_of(arguments.output, report_warning);
  PartialFile output(arguments.output, Existing::kReplace);
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, context.open_backends);
  options.level = arguments.level >= 0
                      ? arguments.level
                      : store.attributes()[store.attribute("position")].finest_level;
  ExportResult result;
  {
    ProgressBar progress("export", ProgressUnit::kNone);
    options.progress = [&](const Progress& now) { return progress.update(now.done, now.total); };
    result = build_output(output, [&] { return export_mesh(store, output.file(), options); });
  }
  throw_if_interrupted();
  output.publish();

  if (!context.json) {
    print(fmt::format("{}: level {}, {} vertices, {} triangles, {}, {:.2f} s\n",
                      output.final_path().native(), options.level, format_count(result.vertices),
                      format_count(result.triangles), format_bytes(result.file_bytes),
                      clock.seconds()));
    return kExitDone;
  }
  const nlohmann::ordered_json report = {{"store", arguments.store.string()},
                                         {"file", output.final_path().string()},
                                         {"level", options.level},
                                         {"vertices", result.vertices},
                                         {"faces", result.triangles},
                                         {"file_bytes", result.file_bytes},
                                         {"seconds", clock.seconds()}};
  print(report.dump(2) + "\n");
  return kExitDone;
}

}  // namespace

void add_export_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ExportArguments>();
  CommandLine* command =
      program.add_subcommand("export", "Write one level of a store as a mesh file");
  command->add_option("STORE", arguments->store, "The store")->required();
  add_output_option(*command, "OUT", arguments->output,
                    "The file to make, or to replace: NAME.(ply|obj|stl)[.gz|.zst]")
      ->required();
  add_level_option(*command, arguments->level, "The level; default: the finest");
  command
      ->add_option(
          "--attribute", arguments->attributes,
          "Also write this attribute, such as normal; for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option(
          "--face-attribute", arguments->face_attributes,
          "Also write this attribute of the base faces as a property of the triangles (PLY "
          "only); for more, repeat the option or give a,b")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "The command needs only the memory of its budget, for any level. The file has base vertices\n"
      "first, then vertices by level in slot order, then triangles. Vertices of a coarser level\n"
      "have the positions that the finest level gives them. PLY is binary and can\n"
      "have every attribute but 64-bit integers: normal as nx ny nz, color as red green blue "
      "alpha,\n"
      "texture as s t, others as NAME or NAME_0 NAME_1 ...; plait import reads them back. OBJ can\n"
      "have normals.\n"
      "\n"
      "Examples:\n"
      "  plait export surface.plait surface.ply --attribute normal\n"
      "  plait export surface.plait coarse.obj.gz --level 2");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_export(*arguments, context); };
  });
}

}  // namespace plait
