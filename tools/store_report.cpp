#include "store_report.h"

#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/store_info.h"
#include "report_json.h"

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

/// Ranges of levels with the same pipeline, coarser ones first. `pipelines` begin after `level`.
Json pipelines_report(int level, std::span<const Pipeline> pipelines) {
  Json ranges = Json::array();
  for (const Pipeline& pipeline : pipelines) {
    ++level;
    if (ranges.empty() || ranges.back()["pipeline"] != pipeline.to_text())
      ranges.push_back(
          {{"first_level", level}, {"last_level", level}, {"pipeline", pipeline.to_text()}});
    ranges.back()["last_level"] = level;
  }
  return ranges;
}

Json attribute_head(const AttributeSchema& schema, int finest_level) {
  return {{"name", schema.name},
          {"type", to_string(schema.type)},
          {"components", schema.components},
          {"record_bytes", schema.record_bytes()},
          {"finest_level", finest_level}};
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

Json attribute_report(Store& store, AttributeId id) {
  const AttributeInfo& info = store.attributes()[id];
  Json levels = Json::array();
  std::vector<Pipeline> pipelines;
  for (int level = store.base_level() + 1; level <= info.finest_level; ++level) {
    const LevelFile& file = StoreAccess::level_file(store, id, level);
    levels.push_back(level_report(file, level));
    pipelines.push_back(file.pipeline);
  }
  Json report = attribute_head(info.schema, info.finest_level);
  report["base_bytes"] = std::as_const(store).base_bytes(id).size();
  report["pipelines"] = pipelines_report(store.base_level(), pipelines);
  report["levels"] = std::move(levels);
  if (const auto& rounding = StoreAccess::rounding(store, id))
    report["max_error"] = rounding_json(*rounding);
  return report;
}

}  // namespace

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

Json closed_store_report(const StoreDescription& store, const std::filesystem::path& path,
                         const std::string& why) {
  Json attributes = Json::array();
  for (const StoreDescription::Attribute& attribute : store.attributes) {
    attributes.push_back(attribute_head(attribute.schema, attribute.finest_level));
    attributes.back()["pipelines"] =
        pipelines_report(store.provenance.base_level, attribute.pipelines);
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

}  // namespace plait
