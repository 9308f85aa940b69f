// plait import: makes a store of a mesh that is semi-regular already.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "argument_text.h"
#include "arguments.h"
#include "base/byte_text.h"
#include "command.h"
#include "compress_arguments.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "measure.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/import_mesh.h"
#include "progress.h"

namespace plait {
namespace {

struct ImportArguments {
  std::optional<std::string> layout;
  std::vector<std::string> compress;
  ImportRequest request;  ///< request_of() adds the members above
};

ImportRequest request_of(const ImportArguments& arguments) {
  ImportRequest request = arguments.request;
  if (!arguments.compress.empty()) request.pipeline_of = pipelines_of(arguments.compress);
  if (arguments.layout) request.layout = layout_from_name(*arguments.layout);
  return request;
}

/// A progress bar for each phase.
class ImportWatcher {
 public:
  ImportWatch watch() {
    return {[this](const Progress& now) {
              if (phase_ != now.phase) {
                phase_ = now.phase;
                progress_.emplace(fmt::format("import: {}", now.phase), ProgressUnit::kNone);
              }
              return progress_->update(now.done, now.total);
            },
            [this](const std::string& warning) {
              if (progress_) progress_->clear();
              report_warning(warning);
            }};
  }

 private:
  std::string phase_;
  std::optional<ProgressBar> progress_;
};

std::string import_text(const ImportArguments& arguments, const ImportResult& result) {
  std::string attributes;
  for (const AttributeSchema& schema : result.attributes)
    attributes += fmt::format("{}{} {} x {}", attributes.empty() ? "" : ", ", schema.name,
                              to_string(schema.type), schema.components);
  std::string text = fmt::format(
      "{}: {} vertices, {} levels over {} vertices and {} faces; {}\n{}: {} by backend {} ({}), "
      "{:.2f} s to read, {:.2f} s to find the levels, {:.2f} s to write\n",
      arguments.request.mesh.native(), format_count(result.vertices),
      result.levels - result.base_level, format_count(result.base_vertices),
      format_count(result.base_faces), attributes, arguments.request.store.native(),
      format_bytes(result.stored_bytes), result.backend, result.backend_reason, result.read_seconds,
      result.recover_seconds, result.write_seconds);
  if (result.base_level > 0)
    text += fmt::format("level {} is the base mesh of the store, so that slots stay small\n",
                        result.base_level);
  if (result.had_choice)
    text += "several base meshes are equally deep: this one keeps the smallest vertex numbers\n";
  if (!result.next_level.empty()) text += result.next_level + "\n";
  return text;
}

nlohmann::ordered_json to_json(const ImportArguments& arguments, const ImportResult& result) {
  nlohmann::ordered_json report = {{"mesh", arguments.request.mesh.string()},
                                   {"store", arguments.request.store.string()},
                                   {"vertices", result.vertices},
                                   {"faces", result.faces},
                                   {"merged_vertices", result.merged_vertices},
                                   {"seam_vertices", result.seam_vertices},
                                   {"levels", result.levels},
                                   {"base_level", result.base_level},
                                   {"base_vertices", result.base_vertices},
                                   {"base_faces", result.base_faces},
                                   {"border_edges", result.border_edges},
                                   {"had_choice", result.had_choice},
                                   {"next_level", result.next_level}};
  for (const AttributeSchema& schema : result.attributes)
    report["attributes"].push_back({{"name", schema.name},
                                    {"type", std::string(to_string(schema.type))},
                                    {"components", schema.components}});
  report["backend"] = result.backend;
  report["backend_reason"] = result.backend_reason;
  report["stored_bytes"] = result.stored_bytes;
  report["memory_bytes"] = result.memory_bytes;
  report["peak_rss_bytes"] = peak_rss_bytes();
  report["read_seconds"] = result.read_seconds;
  report["recover_seconds"] = result.recover_seconds;
  report["write_seconds"] = result.write_seconds;
  report["cpu_seconds"] = cpu_seconds();
  report["seconds"] = seconds_since_start();
  return report;
}

int run_import(const ImportArguments& arguments, const CommandContext& context) {
  ImportResult result;
  {
    ImportWatcher watcher;
    result = import_mesh(request_of(arguments), context.backends, watcher.watch());
  }
  print(context.json ? json_text(to_json(arguments, result)) : import_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_import_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ImportArguments>();
  arguments->request.threads = default_thread_count();
  CommandLine* command = program.add_subcommand(
      "import", "Make a store of a mesh that has subdivision levels already");
  ImportRequest& request = arguments->request;
  command->add_option("FINE", request.mesh, "PLY, OBJ, OFF or STL, also .gz and .zst")->required();
  add_output_option(*command, "STORE", request.store, "The store to make, a directory")->required();
  command
      ->add_parsed_option(
          "--levels",
          [&request](const std::string& text) {
            if (text != "all")
              request.levels = static_cast<int>(parse_whole_number(text, 1, kMaxLevel));
          },
          fmt::format("So many levels, 1 to {}, or all that there are", kMaxLevel))
      ->type_name("N|all")
      ->default_str("all");
  add_precision_option(*command, request.precision,
                       "Type of the positions: float32, float64 or auto: as in a PLY file; for "
                       "other files float32, unless it moves a vertex by more than a thousandth of "
                       "the shortest edge there");
  add_weld_option(*command, request.weld);
  command->add_option("--backend", request.backend,
                      "The backend that stores the levels (see below); default auto");
  add_compress_option(*command, arguments->compress);
  command->add_option("--layout", arguments->layout,
                      "Order of edges on disk: auto (default), given, spatial, hilbert or rcm");
  add_size_option(*command, "--block", request.block_bytes, "Unit of I/O, a power of two");
  add_size_option(*command, "--max-slot", request.max_slot_bytes,
                  "Largest slot of positions: take a finer base mesh until all slots fit");
  add_size_option(*command, "--memory", request.budget_bytes, "Budget for blocks in memory");
  add_threads_option(*command, request.threads, "Threads that write");
  command->add_flag("--force", request.replace,
                    "Replace STORE if it is a store, when the new store is complete");
  command->add_flag("--ignore-size", request.ignore_size,
                    "Start even if the memory is too small for the mesh");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      backend_help(context.backends) + compression_help() +
      "\n"
      "The triangles of FINE must be those of a coarser mesh, each split into four at the middles\n"
      "of its sides, again and again; vertices may lie anywhere, and vertices, faces and corners\n"
      "may come in any order. Corners of STL files with equal positions are one vertex.\n"
      "The command finds the coarsest mesh, or the mesh N levels below FINE. Numbers of FINE keep\n"
      "their bits; --precision float32 narrows positions. Vertex properties of PLY files become "
      "attributes: nx ny nz \"normal\", red\n"
      "green blue alpha \"color\", s t or u v \"texture\", NAME_0 NAME_1 ... \"NAME\", and all "
      "others\n"
      "their own names; plait export writes them again.\n"
      "A mesh without levels is refused, and the message says where the levels end: plait remesh\n"
      "makes levels for such a mesh.\n"
      "The mesh must fit into the memory, with 100 bytes for each vertex.\n"
      "\n"
      "Examples:\n"
      "  plait import sculpture.ply sculpture.plait\n"
      "  plait import sculpture.obj.gz sculpture.plait --levels 3\n"
      "  plait import part.stl part.plait --compress small --memory 1GiB");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_import(*arguments, context); };
  });
}

}  // namespace plait
