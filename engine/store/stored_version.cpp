#include "store/stored_version.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "format/base_mesh_file.h"
#include "format/base_records_file.h"
#include "format/change_record.h"
#include "format/checksum.h"
#include "format/depths_file.h"
#include "format/file_names.h"
#include "format/version_file.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/file.h"
#include "store/parts/shard_place.h"
#include "store/parts/shard_tables.h"
#include "store/version_sizes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::vector<std::string> StoredLevel::file_names() const {
  if (shards == 0) return {level_file_name(number, level, record.generation)};
  std::vector<std::string> names;
  for (std::uint32_t shard = 0; shard < shards; ++shard)
    names.push_back(shard_file_name(shares_files, number, level, record.generation, shard));
  return names;
}

StoredVersion::StoredVersion(const Directory& store, OpenVersion version)
    : store_(store),
      manifest_(version.manifest),
      file_(std::move(version.file)),
      description_bytes_(read_description(file_)),
      description_(decode_description(description_bytes_, manifest_.described, file_.path(),
                                      manifest_.optional_features, manifest_.required_features)),
      is_newest_(version.is_newest) {
  check_counts(description_, file_.path());
  refuse_holes(store_, description_, manifest_.described);
}

EdgeShards StoredVersion::shards() const {
  if (description_.shards.empty()) return {};
  std::vector<EdgeId> starts;
  for (const ShardRecord& shard : description_.shards) starts.push_back(shard.first_edge);
  return {std::move(starts), description_.edge_count};
}

StoreOptions StoredVersion::options() const {
  StoreOptions options;
  options.backend = description_.backend;
  options.pipeline = description_.pipeline;
  options.block_bytes = description_.block_bytes;
  return options;
}

const RegisteredBackend& StoredVersion::find_backend(const BackendRegistry& backends) const {
  const std::string& path = file_.path().native();
  try {
    const RegisteredBackend& backend = backends.find(description_.backend);
    backend.check_machine();
    backend.check_pipelines(description_.pipeline, {});
    for (const AttributeRecord& attribute : description_.attributes) {
      backend.check_pipelines(attribute.pipeline, attribute.schema);
      const Pipeline* checked = nullptr;
      for (const LevelRecord& level : attribute.levels) {
        if (!checked || level.pipeline != *checked)
          backend.check_pipelines(level.pipeline, attribute.schema);
        checked = &level.pipeline;
      }
    }
    if (manifest_.log.generation != 0 && !backend.traits.overwrites_in_place)
      throw Error(ErrorCode::kNotSupported,
                  "the store has a change log, and the backend writes none");
    if (backend.traits.durable) return backend;
  } catch (const Error& error) {
    // kInvalidArgument becomes kNotSupported, because the user did not choose these options.
    // Another program may support them.
    throw Error(ErrorCode::kNotSupported, fmt::format("open {}: {}", path, error.what()));
  }
  throw Error(ErrorCode::kCorruption,
              fmt::format("open {}: backend '{}' writes no files", path, description_.backend));
}

BaseMesh StoredVersion::read_base_mesh() const {
  const File file(store_, kBaseMeshName, OpenMode::kRead);
  BaseMesh mesh =
      read_base_mesh_file(file, {description_.base_mesh_bytes, description_.base_mesh_checksum},
                          description_.vertex_count, description_.face_count);
  if (mesh.edge_count() == description_.edge_count &&
      mesh.border_edge_count() == description_.border_edge_count)
    return mesh;
  throw Error(
      ErrorCode::kCorruption,
      fmt::format("open {}: expected {} edges and {} border edges, as {} says, found {} and "
                  "{}",
                  file.path().native(), description_.edge_count, description_.border_edge_count,
                  version_name(), mesh.edge_count(), mesh.border_edge_count()));
}

BaseMesh StoredVersion::with_depths(BaseMesh base) const {
  if (!description_.depths) return base;
  const DepthsRecord& expected = *description_.depths;
  BaseMesh result = base.with_depths(read_depths_file(
      store_, description_.face_count, description_.provenance.base_level, expected.checksum));
  const std::vector<std::uint32_t> found = slots_of_levels(*result.depths());
  if (found == expected.slots) return result;
  throw Error(ErrorCode::kCorruption,
              fmt::format("open {}: expected depths that give the numbers of slots in {}, found "
                          "others",
                          store_.path_of(kDepthsName).native(), version_name()))
      .about(store_.path_of(kDepthsName));
}

ExpectedBase StoredVersion::expected_base() const {
  return {{description_.vertex_count, description_.edge_count, description_.face_count,
           description_.border_edge_count},
          description_.base_mesh_checksum};
}

std::optional<BaseMesh> StoredVersion::open_base_index() const {
  return open_base_index_file(store_, expected_base());
}

void StoredVersion::check_base_index(const BaseMesh* base) const {
  check_base_index_file(store_, expected_base(), base);
}

std::vector<StoredLevel> StoredVersion::levels(const BaseMesh& base) const {
  const int base_level = description_.provenance.base_level;
  // Without the base mesh, which is damaged then, nothing is known but the names of files.
  const EdgeShards cuts = base.edge_count() == description_.edge_count ? shards() : EdgeShards();
  std::vector<StoredLevel> levels;
  for (std::size_t at = 0; at < description_.attributes.size(); ++at) {
    const AttributeRecord& attribute = description_.attributes[at];
    for (std::size_t finer = 0; finer < attribute.levels.size(); ++finer) {
      StoredLevel& stored = levels.emplace_back();
      stored.attribute = at;
      stored.number = attribute.number;
      stored.level = base_level + 1 + static_cast<int>(finer);
      stored.record = attribute.levels[finer];
      stored.shards = shard_count();
      stored.shares_files = description_.shares_files;
      try {
        const BaseRelativeLevel relative = relative_to_base(stored.level, base_level);
        stored.geometry =
            base.geometry(relative, attribute.schema.record_bytes(),
                          block_bytes_of_level(stored.record.pipeline, relative.refinements,
                                               description_.block_bytes))
                .in_shards(cuts);
      } catch (const Error& error) {
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: attribute '{}': {}", file_.path().native(),
                                attribute.schema.name, error.what()));
      }
    }
  }
  return levels;
}

void StoredVersion::check_base_sizes() const {
  plait::check_base_sizes(store_, description_, manifest_.described);
}

void StoredVersion::check_version_file() const {
  if (const std::uint64_t found = file_.size(); found != manifest_.version_bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", file_.path().native(), found,
                            manifest_.version_bytes))
        .about(file_.path());
  const std::uint64_t expected = block_tables_bytes(description_, file_.path());
  if (const std::uint64_t found =
          manifest_.version_bytes - block_tables_offset(description_bytes_.size());
      found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes of block tables, expected {}", file_.path().native(),
                            found, expected))
        .about(file_.path());
  if (!is_newest_) return;
  if (const std::uint64_t found = checksum_of(file_); found != manifest_.version_checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", file_.path().native(),
                            found, manifest_.version_checksum))
        .about(file_.path());
}

void StoredVersion::read_tables_into(std::span<StoredLevel> levels) const {
  check_version_file();
  if (shard_count() > 0) {
    read_shard_tables_later(store_, manifest_, description_, levels);
    return;
  }
  const std::uint64_t begin = block_tables_offset(description_bytes_.size());
  std::vector<std::byte> bytes(manifest_.version_bytes - begin);
  file_.read_at(begin, bytes);
  BlockTablesReader reader(bytes, file_.path());
  std::vector<BlockTable> tables;
  for (const StoredLevel& level : levels) {
    const std::vector<BlockEntry> entries =
        reader.next_level(level.geometry, has_log() ? manifest_.log.bytes : 0);
    BlockTable& table =
        tables.emplace_back(manifest_.uuid, level.number, level.level, entries.size());
    std::ranges::copy(entries, table.entries().begin());
    table.set_generation(level.record.generation);
  }
  reader.finish();
  enter_changes(levels, tables);
  for (std::size_t at = 0; at < levels.size(); ++at) levels[at].table = std::move(tables[at]);
}

void StoredVersion::check_shard_tables(std::span<const StoredLevel> levels,
                                       std::uint32_t shard) const {
  std::vector<LevelGeometry> geometries;
  for (const StoredLevel& level : levels) geometries.push_back(level.geometry.shard(shard));
  read_shard_tables(store_, tables_file_name(manifest_.sequence, shard), manifest_.uuid, shard,
                    description_.shards[shard].tables_checksum, geometries);
}

std::vector<std::byte> StoredVersion::version_file_with(
    std::span<const BlockTable* const> tables) const {
  return encode_version_file(description_bytes_, tables);
}

template <class Bytes>
Bytes StoredVersion::read_records(const std::string& name, std::uint64_t bytes,
                                  std::uint64_t checksum) const {
  const File file(store_, name, OpenMode::kRead);
  const std::string& path = file.path().native();
  if (file.size() != bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", path, file.size(), bytes))
        .about(file.path());
  Bytes records(bytes);
  file.read_at(0, records);
  if (const std::uint64_t found = checksum_of(records); found != checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", path, found, checksum))
        .about(file.path());
  return records;
}

void StoredVersion::check_base_file(const AttributeRecord& attribute) const {
  read_records<std::vector<std::byte>>(base_records_name(attribute), attribute.base_bytes,
                                       attribute.base_checksum);
}

ZeroedArray<std::byte> StoredVersion::read_base_records(const AttributeRecord& attribute,
                                                        const BaseMesh& base) const {
  auto records = read_records<ZeroedArray<std::byte>>(
      base_records_name(attribute), attribute.base_bytes, attribute.base_checksum);
  const std::uint64_t bytes = description_.vertex_count * attribute.schema.record_bytes();
  if (records.size() != bytes) {
    ZeroedArray<std::byte> unpacked(bytes);
    const bool follows = follows_base_positions(attribute.schema);
    const auto positions = follows ? base.positions() : std::span<const Vector3<double>>();
    if (const auto reason = decode_base_records(attribute.schema, records, positions, unpacked)) {
      const std::filesystem::path path = store_.path_of(base_records_name(attribute));
      throw Error(ErrorCode::kCorruption, fmt::format("open {}: {}", path.native(), *reason))
          .about(path);
    }
    records = std::move(unpacked);
  }
  for (const ChangeRecord& change : changes())
    for (const ChangedRecords& piece : change.records)
      if (piece.attribute == attribute.number) read_piece(piece, records);
  return records;
}

void StoredVersion::read_piece(const ChangedRecords& piece, std::span<std::byte> records) const {
  const File log(store_, log_name(), OpenMode::kRead);
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("open {}: base records at byte {}: {}",
                                                     log.path().native(), piece.offset, reason))
        .about(log.path(), piece.offset);
  };
  if (piece.first > records.size() || piece.bytes > records.size() - piece.first)
    throw refuse(fmt::format("expected bytes among the {} of the attribute, found {} from {}",
                             records.size(), piece.bytes, piece.first));
  const std::span<std::byte> into = records.subspan(piece.first, piece.bytes);
  log.read_at(piece.offset, into);
  if (const std::uint64_t found = checksum_of(into); found != piece.checksum)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, piece.checksum));
}

const std::vector<ChangeRecord>& StoredVersion::changes() const {
  if (changes_ || !has_log()) {
    static const std::vector<ChangeRecord> none;
    return changes_ ? *changes_ : none;
  }
  std::uint64_t entries = block_tables_bytes(description_, file_.path()) / sizeof(BlockEntry);
  for (const AttributeRecord& attribute : description_.attributes)
    entries += 1 + description_.vertex_count * attribute.schema.record_bytes() / kPieceBytes;
  return changes_.emplace(
      read_change_records(File(store_, log_name(), OpenMode::kRead), manifest_, entries));
}

void StoredVersion::enter_changes(std::span<const StoredLevel> levels,
                                  std::span<BlockTable> tables) const {
  for (const ChangeRecord& change : changes())
    for (const ChangedBlock& changed : change.blocks) {
      const auto level = std::ranges::find_if(levels, [&](const StoredLevel& one) {
        return one.number == changed.attribute && one.level == static_cast<int>(changed.level);
      });
      const std::filesystem::path path = store_.path_of(log_name());
      const auto refuse = [&] {
        return Error(ErrorCode::kCorruption,
                     fmt::format("open {}: version {} changes block {} of level {} of attribute "
                                 "{}, which the store does not have",
                                 path.native(), change.version, changed.block, changed.level,
                                 changed.attribute))
            .about(path, changed.offset);
      };
      if (level == levels.end() || changed.block >= level->geometry.block_count()) throw refuse();
      BlockTable& table = tables[static_cast<std::size_t>(level - levels.begin())];
      const std::uint64_t bytes = level->geometry.block_bytes(changed.block);
      if (bytes > manifest_.log.bytes - changed.offset) throw refuse();
      table.entries()[changed.block] = {changed.offset, static_cast<std::uint32_t>(bytes),
                                        BlockEncoding::kRaw, kLogFile, changed.checksum};
    }
}

std::vector<std::byte> StoredVersion::read_face_records(
    const FaceAttributeRecord& attribute) const {
  return read_records<std::vector<std::byte>>(
      face_records_name(attribute), description_.face_count * attribute.schema.record_bytes(),
      attribute.checksum);
}

std::string StoredVersion::log_name() const { return change_log_name(manifest_.log.generation); }

std::string StoredVersion::version_name() const { return version_file_name(manifest_.described); }

std::string StoredVersion::face_records_name(const FaceAttributeRecord& attribute) const {
  return faces_file_name(attribute.number, manifest_.described);
}

std::string StoredVersion::base_records_name(const AttributeRecord& attribute) const {
  return base_file_name(attribute.number, manifest_.described);
}

std::set<std::string> StoredVersion::file_names(std::uint32_t shards) const {
  std::set<std::string> names = {version_name()};
  if (has_log()) names.insert(log_name());
  for (const FaceAttributeRecord& attribute : description_.face_attributes)
    names.insert(face_records_name(attribute));
  for (const AttributeRecord& attribute : description_.attributes) {
    names.insert(base_records_name(attribute));
    int level = description_.provenance.base_level;
    for (const LevelRecord& record : attribute.levels) {
      ++level;
      if (shards == 0) names.insert(level_file_name(attribute.number, level, record.generation));
      for (std::uint32_t shard = 0; shard < shards; ++shard) {
        names.insert(shard_file_name(description_.shares_files, attribute.number, level,
                                     record.generation, shard));
        if (description_.shards.empty())
          names.insert(shard_file_name(attribute.number, record.generation, shard));
      }
    }
  }
  for (std::uint32_t shard = 0; shard < shards; ++shard)
    names.insert(tables_file_name(manifest_.sequence, shard));
  return names;
}

PLAIT_END_NAMESPACE
