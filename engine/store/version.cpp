// Writes a version (base records, description, block tables, manifest slot), and reads one.
#include <fmt/format.h>

#include <algorithm>

#include "plait/error.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/recovery.h"
#include "store/store_state.h"
#include "store/stored_version.h"
#include "store/version_description.h"
#include "store/version_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Creates the file. Replaces a file that an earlier run left under its name.
void write_whole_file(const Directory& store, const std::string& name,
                      std::span<const std::byte> bytes, bool durable) {
  store.remove(name);
  File file(store, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  if (durable) file.sync();
  file.close();
}

bool has_predicted(const BlockTable& table) {
  return std::ranges::find(table.entries(), BlockEncoding::kPredicted, &BlockEntry::encoding) !=
         table.entries().end();
}

}  // namespace

VersionDescription Store::Implementation::description() const {
  VersionDescription result;
  result.vertex_count = base.vertex_count();
  result.edge_count = base.edge_count();
  result.face_count = base.face_count();
  result.border_edge_count = base.border_edge_count();
  result.block_bytes = options.block_bytes;
  result.next_attribute_number = next_number;
  result.base_mesh_bytes = base_mesh_size.bytes;
  result.base_mesh_checksum = base_mesh_size.checksum;
  result.backend = options.backend;
  result.pipeline = options.pipeline;
  result.provenance = provenance;
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    result.attributes.push_back(attributes[i].record);
    result.attributes.back().schema = infos[i].schema;
  }
  return result;
}

void Store::Implementation::write_version() {
  const bool durable = options.durability == Durability::kCommit;
  for (const Attribute& attribute : attributes)
    for (const auto& level : attribute.levels) level->backend->sync(durable);
  enter_renewed_levels();

  if (sequence == kMaxSequence)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("commit {}: version {} is the last that a store can have",
                            path.native(), sequence));
  Manifest next;
  next.uuid = uuid;
  next.sequence = sequence + 1;
  VersionDescription content = description();
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    if (attributes[i].derived) {
      next.required_features |= kDerivedAttributes;
      continue;
    }
    write_whole_file(directory, base_file_name(attributes[i].record.number, next.sequence),
                     attributes[i].base_bytes, durable);
    content.attributes[i].base_checksum = checksum_of(attributes[i].base_bytes);
  }
  std::vector<const BlockTable*> all_tables;
  for (const Attribute& attribute : attributes)
    for (const auto& level : attribute.levels) {
      if (level->is_derived) continue;
      all_tables.push_back(&level->table);
      if (has_predicted(level->table)) next.required_features |= kPredictedBlocks;
    }
  const std::vector<std::byte> described =
      encode_version_file(encode_description(content), all_tables);
  write_whole_file(directory, version_file_name(next.sequence), described, durable);
  // Both versions stay locked against readers until the manifest names the new one.
  File next_file;
  if (overwrites_in_place()) {
    next_file = File(directory, version_file_name(next.sequence), OpenMode::kRead);
    if (!next_file.lock(true))
      throw Error(ErrorCode::kBusy, fmt::format("commit {}: another process has locked {}",
                                                path.native(), next_file.path().native()));
  }
  next.version_bytes = described.size();
  next.version_checksum = checksum_of(described);
  next.optional_features = optional_features_of(content);
  if (durable) directory.sync();

  File file(directory, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, next);
  if (durable) file.sync();
  file.close();
  if (durable && !name_is_durable) {
    directory.parent().sync();
    name_is_durable = true;
  }

  // The version is committed. An error in the removal of old files does not change that.
  sequence = next.sequence;
  version_file = std::move(next_file);
  try {
    versions_read = remove_old_versions(directory);
  } catch (const Error&) {
    // It is not known which versions have readers. They can only be the versions that had readers
    // before, and the previous version.
    if (sequence > 1) versions_read.push_back(sequence - 1);
  }
  volume->begin_version(sequence, versions_read);
}

void Store::Implementation::enter_renewed_levels() {
  if (generations == nullptr) return;
  for (const GenerationVolume::Level& renewed : generations->renewed_levels())
    for (Attribute& attribute : attributes) {
      if (attribute.record.number != renewed.attribute) continue;
      const auto at = static_cast<std::size_t>(renewed.level - options.base_level - 1);
      attribute.record.levels[at].generation = sequence + 1;
      attribute.levels[at]->path =
          directory.path_of(level_file_name(renewed.attribute, renewed.level, sequence + 1));
    }
}

void Store::Implementation::hold_versions() {
  if (backend.traits.overwrites_in_place)
    return;  // the backend does not change blocks of these versions
  for (const std::uint64_t number : versions_read) {
    const StoredVersion older(directory, open_older_version(directory, uuid, number));
    held.push_back({number, older.levels(base)});
    older.read_tables_into(held.back().levels);
  }
}

void Store::Implementation::read_version(const StoredVersion& version, OpenMode mode) {
  std::vector<StoredLevel> levels = version.levels(base);
  version.read_tables_into(levels);
  for (const AttributeRecord& stored : version.description().attributes) {
    Attribute attribute;
    attribute.record = stored;
    follow_pipeline(attribute, stored.schema);
    if (!attribute.derived) attribute.base_bytes = version.read_base_records(stored);
    infos.push_back({stored.schema, version.description().finest_level(stored)});
    attributes.push_back(std::move(attribute));
  }
  for (StoredLevel& level : levels) {
    const auto attribute = static_cast<AttributeId>(level.attribute);
    const AttributeInfo& info = infos[attribute];
    attributes[attribute].levels.push_back(
        level.is_derived()
            ? open_derived_level(attributes[attribute], info.schema, level.level, info.finest_level)
            : open_level(std::move(level), info.schema, mode));
  }
  connect_derived();
  for (const Attribute& attribute : attributes)
    if (attribute.derived && !attribute.derived->refusal().empty())
      throw Error(ErrorCode::kCorruption, fmt::format("open {}: a derived attribute: {}",
                                                      path.native(), attribute.derived->refusal()));
}

PLAIT_END_NAMESPACE
