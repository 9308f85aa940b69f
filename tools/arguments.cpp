#include "arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "plait/compression.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/progress.h"
#include "plait/registry.h"

namespace plait {

Option* add_size_option(CommandLine& command, const std::string& name, std::uint64_t& value,
                        const std::string& description) {
  return command
      .add_parsed_option(
          name, [&value](const std::string& text) { value = parse_size(text); }, description)
      ->type_name("SIZE")
      ->default_str(size_text(value));
}

Option* add_threads_option(CommandLine& command, int& threads, const std::string& description) {
  constexpr std::uint64_t kMostThreads = 1024;
  threads = thread_count(0, "threads");
  return command
      .add_parsed_option(
          "--threads",
          [&threads](const std::string& text) {
            threads = thread_count(static_cast<int>(parse_whole_number(text, 0, kMostThreads)),
                                   "threads");
          },
          description + "; 0: all processors")
      ->type_name("N")
      ->default_str("0");
}

Option* add_level_option(CommandLine& command, int& level, const std::string& description) {
  return add_whole_option(command, "--level", level, 0, kMaxLevel, description);
}

Option* add_output_option(CommandLine& command, const std::string& name,
                          std::filesystem::path& path, const std::string& description) {
  return command
      .add_parsed_option(
          name,
          [&path](const std::string& text) {
            if (text.empty() || text == "-")
              throw Error(ErrorCode::kInvalidArgument,
                          fmt::format("expected a name (nothing is written to standard output; "
                                      "./- is a file called -), found \"{}\"",
                                      text));
            path = text;
          },
          description)
      ->type_name("PATH");
}

Option* add_plugin_option(CommandLine& command, CommandContext& context) {
  return command
      .add_option("--plugin", context.plugin_files,
                  "Load a plug-in, a shared library (may be repeated)")
      ->type_name("FILE")
      ->allow_extra_args(false);
}

Option* add_json_option(CommandLine& command, CommandContext& context) {
  return command.add_flag("--json", context.json,
                          "Print one JSON object, and nothing else, to standard output");
}

std::string compression_help() {
  AttributeSchema position;
  position.name = "position";
  std::string text = "\nPresets of --compress, and what they choose for positions:\n";
  for (const CompressionPreset& preset : compression_presets())
    text += fmt::format("  {:<12} {}: {}\n", preset.name,
                        preset_pipeline(preset.name, position).to_text(), preset.summary);
  const PipelineRegistry& pipelines = default_pipelines();
  text +=
      "With default and small, what a scheme made takes no bytes, nor do normals that follow from\n"
      "the positions: reading makes them again.\n";
  text += fmt::format("Filters: {}. Codecs: {}. Plug-ins add others.\n",
                      fmt::join(pipelines.filter_names(), ", "),
                      fmt::join(pipelines.codec_names(), ", "));
  text +=
      "--compress position@1-3=shuffle,zstd:19 is for levels 1 to 3, @6-=fast for level 6 and all\n"
      "finer ones. A text that names the attribute goes before one that does not, then the "
      "smaller\n"
      "range of levels before the larger, then the later text before the earlier.\n";
  return text;
}

std::string max_error_help() {
  return "--max-error 1e-5 rounds positions so that no coordinate changes by more than 1e-5, and\n"
         "1e-6rel by more than a millionth of the diagonal of the base vertices' box. With\n"
         ",euclidean, no vertex moves farther. normal=1e-3 rounds normals. Base vertices, and\n"
         "what has no bound, stay exact; plait info prints the errors.";
}

std::string backend_help(const BackendRegistry& backends) {
  std::string text = "Backends:\n";
  for (const std::string& name : backends.names())
    text += fmt::format("  {:<12} {}\n", name, backends.find(name).summary);
  return text;
}

}  // namespace plait
