// Writes a version (base records, description, block tables, manifest slot), and reads one.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "format/base_index_file.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "format/depths_file.h"
#include "format/file_names.h"
#include "format/version_description.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "store/generation_volume.h"
#include "store/recovery.h"
#include "store/store_state.h"
#include "store/stored_version.h"
#include "store/version_writer.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

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
  result.pipeline = *options.pipeline;
  result.provenance = provenance;
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    if (!attributes[i].becomes.empty()) continue;  // commit() refuses the store while it has one
    result.attributes.push_back(attributes[i].record);
    result.attributes.back().schema = infos[i].schema;
    for (std::size_t at = 0; at < attributes[i].levels.size(); ++at) {
      result.attributes.back().levels[at].generation = attributes[i].levels[at]->table.generation();
    }
  }
  for (std::size_t i = 0; i < face_attributes.size(); ++i)
    result.face_attributes.push_back(
        {face_infos[i], face_attributes[i].number, face_attributes[i].checksum});
  result.texts = texts;
  if (base.depths() != nullptr) result.depths = {depths_checksum, slots_of_levels(*base.depths())};
  return result;
}

std::filesystem::path Store::Implementation::path_of(const LevelFile& level) const {
  const BlockTable& table = level.table;
  return directory.path_of(level_file_name(table.attribute(), table.level(), table.generation()));
}

void Store::Implementation::write_version() {
  const bool durable = options.durability == Durability::kCommit;
  if (sequence == kMaxSequence)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("commit {}: version {} is the last that a store can have",
                            path.native(), sequence));
  for (const Attribute& attribute : attributes)
    for (const auto& level : attribute.levels) level->backend->sync(durable);
  if (!write_changes(durable)) write_whole_version(durable);
  if (durable && !name_is_durable) {
    directory.parent().sync();
    name_is_durable = true;
  }

  // The version is committed. An error in the removal of old files does not change that.
  ++sequence;
  if (committed.described == sequence) try {
      versions_read = remove_old_versions(directory);
    } catch (const Error&) {
      // It is not known which versions have readers. They can only be the versions that had readers
      // before, and the previous version.
      if (sequence > 1) versions_read.push_back(sequence - 1);
    }
  volume->begin_version(sequence, versions_read);
  for (Attribute& attribute : attributes)
    for (const auto& level : attribute.levels) level->path = path_of(*level);
}

bool Store::Implementation::write_changes(bool durable) {
  const bool has_room = sequence - committed.described < kMostChangeRecords;
  if (!generations || changed || !has_room || !generations->is_small_commit() ||
      (!has_base_index && wants_index(options.base_index, base)))
    return false;
  for (const FaceAttribute& attribute : face_attributes)
    if (attribute.checksum_now != attribute.checksum) return false;
  std::vector<ChangedRecords> records;
  std::vector<std::span<const std::byte>> pieces;
  for (const Attribute& attribute : attributes) {
    if (!attribute.base_changes.must_be_looked_for()) continue;
    const std::span<const std::byte> bytes = attribute.base_bytes;
    for (std::size_t piece = 0; piece < attribute.piece_checksums_now.size(); ++piece) {
      if (attribute.piece_checksums_now[piece] == attribute.piece_checksums[piece]) continue;
      const std::uint64_t first = piece * kPieceBytes;
      pieces.push_back(bytes.subspan(first, std::min(kPieceBytes, bytes.size() - first)));
      records.push_back({attribute.record.number, 0, first, pieces.back().size()});
    }
  }
  Manifest next = committed;
  next.sequence = sequence + 1;
  next.log = generations->commit_changes(committed.log, pieces, std::move(records), durable);
  publish_changes(directory, lock, next, durable);
  committed = next;
  return true;
}

void Store::Implementation::write_whole_version(bool durable) {
  VersionContent content{description(), {}, {}};
  if (generations) content.log = generations->finish_log(durable);
  for (const Attribute& attribute : attributes) {
    const File* const file = attribute.base_bytes.file();
    content.base_files.push_back(file);
    content.base_records.push_back(file == nullptr ? attribute.base_bytes
                                                   : std::span<const std::byte>());
    for (const auto& level : attribute.levels) content.tables.push_back(&level->table);
  }
  for (const FaceAttribute& attribute : face_attributes)
    content.face_records.push_back(attribute.bytes);
  if (backend.traits.compressed) content.positions = base.positions();
  if (!has_base_index && wants_index(options.base_index, base)) {
    add_base_index_file(directory, base, base_mesh_size.checksum, durable);
    has_base_index = true;
  }
  committed = publish_version(directory, lock, uuid, sequence + 1, std::move(content), durable);
}

BaseRecords Store::Implementation::base_records_in_file(std::uint32_t attribute,
                                                        std::uint64_t bytes) const {
  const std::string name = base_file_name(attribute, sequence + 1);
  directory.remove(name);
  return {File(directory, name, OpenMode::kCreate), bytes};
}

void Store::Implementation::hold_versions() {
  if (backend.traits.overwrites_in_place)
    return;  // the backend does not change blocks of these versions
  // All versions of a store have the same depths.
  const std::uint32_t features = base.depths() != nullptr ? std::uint32_t{kDepths} : 0;
  for (const std::uint64_t number : versions_read) {
    const StoredVersion older(directory, open_older_version(directory, uuid, number, features));
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
    attribute.base_bytes = version.read_base_records(stored, base);
    infos.push_back({stored.schema, version.description().finest_level(stored)});
    attributes.push_back(std::move(attribute));
  }
  texts = version.description().texts;
  for (const FaceAttributeRecord& stored : version.description().face_attributes) {
    face_attributes.push_back({stored.number, stored.checksum, version.read_face_records(stored)});
    face_infos.push_back(stored.schema);
  }
  for (StoredLevel& level : levels) {
    const auto attribute = static_cast<AttributeId>(level.attribute);
    const AttributeInfo& info = infos[attribute];
    attributes[attribute].levels.push_back(open_level(std::move(level), info.schema, mode));
  }
}

PLAIT_END_NAMESPACE
