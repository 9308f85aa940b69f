// plait info: prints the properties of a store.

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "json_text.h"
#include "plait/extend/check_store.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/store.h"
#include "plait/store_info.h"
#include "report_json.h"
#include "report_text.h"
#include "store_report.h"

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string count_of(const Json& value) { return format_count(value.get<std::uint64_t>()); }
std::string bytes_of(const Json& value) { return format_bytes(value.get<std::uint64_t>()); }
std::string text_of(const Json& value) { return value.get<std::string>(); }

/// A level of which all blocks are predicted takes no bytes.
std::string level_ratio(const Json& level) {
  return level["stored_bytes"] == 0 ? "-" : fmt::format("{:.2f}", level["ratio"].get<double>());
}

/// "level 4" or "levels 1-3".
std::string levels_of(const Json& range) {
  const int first = range["first_level"].get<int>(), last = range["last_level"].get<int>();
  return first == last ? fmt::format("level {}", first) : fmt::format("levels {}-{}", first, last);
}

/// Texts have line feeds and tabs, and the terminal shows no other control characters.
void print_notes(const Json& report) {
  for (const auto& [name, text] : report["texts"].items()) {
    std::string shown = text_of(text);
    for (std::size_t at = 0; (at = shown.find('\n', at)) != std::string::npos; at += 12)
      shown.replace(at, 1, "\n           ");
    print(fmt::format("text       {}: {}\n", name, shown));
  }
  for (const Json& attribute : report["face_attributes"])
    print(
        fmt::format("faces      {}: {}\n", text_of(attribute["name"]), text_of(attribute["type"])));
}

void print_name(const Json& report) {
  print(fmt::format("store      {}\nuuid       {}, version {}\n", text_of(report["store"]),
                    text_of(report["uuid"]), report["sequence"].get<std::uint64_t>()));
}

void print_pipelines(const Json& attribute) {
  for (const Json& range : attribute["pipelines"])
    print(fmt::format("  {:<12}{}\n", levels_of(range), text_of(range["pipeline"])));
}

void print_closed_store(const Json& report) {
  const Json& base = report["base"];
  print_name(report);
  print(fmt::format("closed     {}\n", text_of(report["cannot_be_opened"])));
  print(fmt::format("backend    {}, blocks of {}, pipelines {}\n", text_of(report["backend"]),
                    bytes_of(report["block_bytes"]), text_of(report["pipeline"])));
  print(
      fmt::format("layout     {}\nscheme     {}\n", text_of(report["layout"]),
                  text_of(report["scheme"]).empty() ? "not recorded" : text_of(report["scheme"])));
  print(fmt::format("base       level {}: {} vertices, {} edges ({} border), {} faces\n",
                    report["base_level"].get<int>(), count_of(base["vertices"]),
                    count_of(base["edges"]), count_of(base["border_edges"]),
                    count_of(base["faces"])));
  print_notes(report);
  for (const Json& attribute : report["attributes"]) {
    print(fmt::format("\n{}: {} x {}, to level {}\n", text_of(attribute["name"]),
                      text_of(attribute["type"]), attribute["components"].get<int>(),
                      attribute["finest_level"].get<int>()));
    print_pipelines(attribute);
  }
}

void print_info(const Json& report, const Store& store) {
  const Json& base = report["base"];
  const Json& finest = report["finest"];
  print_name(report);
  print(fmt::format("backend    {}, blocks of {}\n", text_of(report["backend"]),
                    bytes_of(report["block_bytes"])));
  if (report["auto_backend"].is_string())
    print(fmt::format("auto       would choose {} for it now: {}\n",
                      text_of(report["auto_backend"]), text_of(report["auto_reason"])));
  const std::string scheme = text_of(report["scheme"]);
  print(fmt::format("layout     {}\nscheme     {}\n", text_of(report["layout"]),
                    scheme.empty()
                        ? "not recorded"
                        : fmt::format("{}{}, {}, by plait {}", scheme,
                                      report["limit"].get<bool>() ? " with limit positions" : "",
                                      text_of(report["precision"]), text_of(report["program"]))));
  print(fmt::format(
      "base       level {}: {} vertices, {} edges ({} border), {} faces; {} in memory\n",
      report["base_level"].get<int>(), count_of(base["vertices"]), count_of(base["edges"]),
      count_of(base["border_edges"]), count_of(base["faces"]), bytes_of(base["memory_bytes"])));
  print(fmt::format("finest     level {}: {} vertices, {} edges, {} faces\n",
                    report["finest_level"].get<int>(), count_of(finest["vertices"]),
                    count_of(finest["edges"]), count_of(finest["faces"])));
  for (const Json& depth : report["depths"])
    print(fmt::format("depth      level {}: {} faces\n", depth["level"].get<int>(),
                      count_of(depth["faces"])));
  print(fmt::format("stored     {}; levels {} of {} raw, {:.2f} to 1\n",
                    bytes_of(report["stored_bytes"]), bytes_of(report["levels_stored_bytes"]),
                    bytes_of(report["levels_raw_bytes"]), report["ratio"].get<double>()));
  print_notes(report);
  for (const Json& attribute : report["attributes"]) {
    print(fmt::format("\n{}: {} x {}, base records {}\n", text_of(attribute["name"]),
                      text_of(attribute["type"]), attribute["components"].get<int>(),
                      bytes_of(attribute["base_bytes"])));
    const AttributeId id = store.attribute(text_of(attribute["name"]));
    if (attribute.contains("max_error"))
      print(fmt::format("  {}\n", rounding_text(attribute["max_error"])));
    if (const Json made = made_blocks_json(store, id); !made.is_null())
      print(fmt::format("  {}", made_blocks_text(made)));
    print_pipelines(attribute);
    print(
        "  level         vertices          raw       stored  ratio    blocks          raw  "
        "predicted\n");
    for (const Json& level : attribute["levels"])
      print(fmt::format("  {:>5} {:>16} {:>12} {:>12} {:>6} {:>9} {:>12} {:>10}\n",
                        level["level"].get<int>(), count_of(level["vertices"]),
                        bytes_of(level["raw_bytes"]), bytes_of(level["stored_bytes"]),
                        level_ratio(level), count_of(level["blocks"]),
                        count_of(level["blocks_raw"]), count_of(level["blocks_predicted"])));
  }
  if (report["compressed"].get<bool>())
    print(
        "\nA block is stored raw if compression would save less than an eighth of it. A predicted\n"
        "block takes no bytes: reading makes it again from the base mesh or from positions.\n");
}

}  // namespace

void add_info_command(CommandLine& program, CommandContext& context) {
  struct Arguments {
    std::filesystem::path path;
    bool build = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  CommandLine* command =
      program.add_subcommand("info", "Print the properties of a store and of its levels");
  Option* const path = command->add_option("STORE", arguments->path, "The store");
  Option* const build =
      command->add_flag("--build", arguments->build,
                        "Print what this build and its plug-ins contain, instead of a store");
  build->excludes(path);
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Reads the manifest and the tables, but no vertices. The ratio is raw bytes divided by\n"
      "stored bytes. A compressed store has a block raw if compression would save less than an\n"
      "eighth of it. A predicted block takes no bytes: reading makes it again. Of a store whose\n"
      "plug-in is missing, the command prints what can be read without it, and exits with 2.\n"
      "\n"
      "Examples:\n"
      "  plait info surface.plait\n"
      "  plait info surface.plait --json\n"
      "  plait info --build\n"
      "  plait info --build --plugin ./libmine.so");
  command->callback([arguments, &context] {
    if (arguments->path.empty() && !arguments->build)
      throw UsageError("STORE: expected a store, or --build");
    context.run = [arguments, &context] {
      if (arguments->build) {
        const Json report = build_report(context.plugins);
        print(context.json ? json_text(report) : build_text(report));
        return kExitDone;
      }
      try {
        Store store = Store::open(arguments->path, OpenOptions(), context.open_backends);
        const Json report = store_report(store, context.backends);
        if (context.json)
          print(json_text(report));
        else
          print_info(report, store);
        return kExitDone;
      } catch (const Error& error) {
        // A plug-in may be missing. What the store says of itself can be read without it.
        if (error.code() != ErrorCode::kNotSupported) throw;
        const Json report =
            closed_store_report(describe_store(arguments->path), arguments->path, error.what());
        if (!context.json) {
          print_closed_store(report);
          throw;
        }
        print(json_text(report));  // has the error too: one object is all of the output
        report_error(to_string(error.code()), error.what(), false);
        return exit_status(error.code());
      }
    };
  });
}

}  // namespace plait
