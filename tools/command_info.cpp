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

namespace plait {
namespace {

using Json = nlohmann::ordered_json;

std::string uuid_text(const StoreUuid& uuid) {
  std::string text;
  for (std::size_t i = 0; i < uuid.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += fmt::format("{:02x}", static_cast<unsigned>(uuid[i]));
  }
  return text;
}

double ratio(std::uint64_t raw_bytes, std::uint64_t stored_bytes) {
  return stored_bytes == 0 ? 0 : static_cast<double>(raw_bytes) / static_cast<double>(stored_bytes);
}

Json level_report(const LevelFile& file, int level) {
  const std::uint64_t raw_bytes = file.geometry.total_bytes();
  const std::uint64_t stored_bytes = file.backend->stored_bytes();
  std::uint64_t never_written = 0, raw = 0, predicted = 0;
  for (const BlockEntry& entry : file.table.entries()) {
    never_written += entry.encoding == BlockEncoding::kNeverWritten ? 1 : 0;
    raw += entry.encoding == BlockEncoding::kRaw ? 1 : 0;
    predicted += entry.encoding == BlockEncoding::kPredicted ? 1 : 0;
  }
  return {{"level", level},
          {"pipeline", file.pipeline.to_text()},
          {"vertices", raw_bytes / file.geometry.record_bytes()},
          {"raw_bytes", raw_bytes},
          {"stored_bytes", stored_bytes},
          {"ratio", ratio(raw_bytes, stored_bytes)},
          {"blocks", file.geometry.block_count()},
          {"blocks_raw", raw},
          {"blocks_predicted", predicted},
          {"blocks_never_written", never_written},
          {"slots_per_block", std::uint64_t{1} << file.geometry.slots_per_block_log2()}};
}

/// Ranges of levels with the same pipeline, coarser ones first.
Json pipelines_report(Store& store, AttributeId id) {
  Json pipelines = Json::array();
  for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level) {
    const std::string pipeline = StoreAccess::level_file(store, id, level).pipeline.to_text();
    if (pipelines.empty() || pipelines.back()["pipeline"] != pipeline)
      pipelines.push_back({{"first_level", level}, {"last_level", level}, {"pipeline", pipeline}});
    pipelines.back()["last_level"] = level;
  }
  return pipelines;
}

Json texts_report(const Texts& texts) {
  Json report = Json::object();
  for (const auto& [name, text] : texts) report[name] = text;
  return report;
}

Json face_attributes_report(std::span<const AttributeSchema> schemas) {
  Json report = Json::array();
  for (const AttributeSchema& schema : schemas)
    report.push_back({{"name", schema.name}, {"type", to_string(schema.type)}});
  return report;
}

/// What a store says of itself that this program cannot open: `why`.
Json closed_store_report(const StoreDescription& store, const std::filesystem::path& path,
                         const std::string& why) {
  Json attributes = Json::array();
  for (const StoreDescription::Attribute& attribute : store.attributes) {
    Json pipelines = Json::array();
    int level = store.provenance.base_level;
    for (const Pipeline& pipeline : attribute.pipelines) {
      ++level;
      if (pipelines.empty() || pipelines.back()["pipeline"] != pipeline.to_text())
        pipelines.push_back(
            {{"first_level", level}, {"last_level", level}, {"pipeline", pipeline.to_text()}});
      pipelines.back()["last_level"] = level;
    }
    attributes.push_back({{"name", attribute.schema.name},
                          {"type", to_string(attribute.schema.type)},
                          {"components", attribute.schema.components},
                          {"record_bytes", attribute.schema.record_bytes()},
                          {"finest_level", attribute.finest_level},
                          {"pipelines", std::move(pipelines)}});
  }
  return {{"store", path.string()},
          {"uuid", uuid_text(store.uuid)},
          {"sequence", store.sequence},
          {"cannot_be_opened", why},
          {"backend", store.options.backend},
          {"pipeline", store.options.pipeline->to_text()},
          {"block_bytes", store.options.block_bytes},
          {"layout", store.provenance.layout},
          {"scheme", store.provenance.scheme},
          {"program", store.provenance.program},
          {"base_level", store.provenance.base_level},
          {"base",
           {{"vertices", store.vertex_count},
            {"edges", store.edge_count},
            {"faces", store.face_count},
            {"border_edges", store.border_edge_count}}},
          {"texts", texts_report(store.texts)},
          {"face_attributes", face_attributes_report(store.face_attributes)},
          {"attributes", std::move(attributes)}};
}

Json attribute_report(Store& store, AttributeId id) {
  const AttributeInfo& info = store.attributes()[id];
  Json levels = Json::array();
  for (int level = store.base_level() + 1; level <= info.finest_level; ++level)
    levels.push_back(level_report(StoreAccess::level_file(store, id, level), level));
  Json report = {{"name", info.schema.name},
                 {"type", to_string(info.schema.type)},
                 {"components", info.schema.components},
                 {"record_bytes", info.schema.record_bytes()},
                 {"finest_level", info.finest_level},
                 {"base_bytes", std::as_const(store).base_bytes(id).size()},
                 {"pipelines", pipelines_report(store, id)},
                 {"levels", std::move(levels)}};
  if (const auto& rounding = StoreAccess::rounding(store, id))
    report["max_error"] = rounding_json(*rounding);
  return report;
}

Json store_report(Store& store, const BackendRegistry& backends) {
  const BaseMesh& base = store.base();
  const StoreOptions& options = store.options();
  const bool compressed = store.info().backend.compressed;
  const LevelCounts finest =
      counts_at_level(base, relative_to_base(store.finest_level(), store.base_level()).refinements);
  Json attributes = Json::array();
  // Of levels, because nothing else is compressed. If all blocks are predicted, the ratio is to the
  // tables.
  std::uint64_t raw_bytes = 0, stored_bytes = 0, table_bytes = 0;
  for (AttributeId id = 0; id < store.attributes().size(); ++id) {
    attributes.push_back(attribute_report(store, id));
    for (const Json& level : attributes.back()["levels"]) {
      raw_bytes += level["raw_bytes"].get<std::uint64_t>();
      stored_bytes += level["stored_bytes"].get<std::uint64_t>();
      table_bytes += level["blocks"].get<std::uint64_t>() * sizeof(BlockEntry);
    }
  }
  const BackendChoice automatic = backends.choose({store.path(), raw_bytes, false, {}});
  Json depths = Json::array();
  for (int level = store.base_level(); store.has_depths() && level <= store.finest_level();
       ++level) {
    std::uint64_t faces = 0;
    for (FaceId face = 0; face < base.face_count(); ++face)
      faces += store.depth(face) == level ? 1u : 0u;
    if (faces > 0) depths.push_back({{"level", level}, {"faces", faces}});
  }
  return {
      {"store", store.path().string()},
      {"uuid", uuid_text(store.info().uuid)},
      {"sequence", store.sequence()},
      {"backend", options.backend},
      {"compressed", compressed},
      {"auto_backend", compressed ? Json(nullptr) : Json(automatic.name)},
      {"auto_reason", compressed ? Json(nullptr) : Json(automatic.reason)},
      {"block_bytes", options.block_bytes},
      {"layout", store.provenance().layout},
      {"scheme", store.provenance().scheme},
      {"limit", store.provenance().limit},
      {"precision", to_string(store.provenance().precision)},
      {"program", store.provenance().program},
      {"base_level", store.base_level()},
      {"finest_level", store.finest_level()},
      {"base",
       {{"vertices", base.vertex_count()},
        {"edges", base.edge_count()},
        {"faces", base.face_count()},
        {"border_edges", base.border_edge_count()},
        {"memory_bytes", base.memory_bytes()}}},
      {"finest", {{"vertices", finest.vertices}, {"edges", finest.edges}, {"faces", finest.faces}}},
      {"depths", std::move(depths)},
      {"texts", texts_report(store.notes().texts())},
      {"face_attributes", face_attributes_report(store.notes().face_attributes())},
      {"stored_bytes", store.info().stored_bytes},
      {"levels_raw_bytes", raw_bytes},
      {"levels_stored_bytes", stored_bytes},
      {"block_tables_bytes", table_bytes},
      {"ratio", ratio(raw_bytes, stored_bytes > 0 ? stored_bytes : table_bytes)},
      {"attributes", std::move(attributes)}};
}

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

void print_closed_store(const Json& report) {
  const Json& base = report["base"];
  print(fmt::format("store      {}\nuuid       {}, version {}\n", text_of(report["store"]),
                    text_of(report["uuid"]), report["sequence"].get<std::uint64_t>()));
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
    for (const Json& range : attribute["pipelines"])
      print(fmt::format("  {:<12}{}\n", levels_of(range), text_of(range["pipeline"])));
  }
}

void print_info(const Json& report, const Store& store) {
  const Json& base = report["base"];
  const Json& finest = report["finest"];
  print(fmt::format("store      {}\nuuid       {}, version {}\n", text_of(report["store"]),
                    text_of(report["uuid"]), report["sequence"].get<std::uint64_t>()));
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
    for (const Json& range : attribute["pipelines"])
      print(fmt::format("  {:<12}{}\n", levels_of(range), text_of(range["pipeline"])));
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
