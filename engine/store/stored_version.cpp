#include "store/stored_version.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"
#include "plait/file.h"
#include "store/base_mesh_file.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/version_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

StoredVersion::StoredVersion(const Directory& store, OpenVersion version)
    : store_(store),
      manifest_(version.manifest),
      file_(std::move(version.file)),
      description_bytes_(read_description(file_)),
      description_(decode_description(description_bytes_, manifest_.sequence, file_.path(),
                                      manifest_.optional_features)) {}

StoreOptions StoredVersion::options() const {
  StoreOptions options;
  options.backend = description_.backend;
  options.pipeline = description_.pipeline;
  options.layout = description_.provenance.layout;
  options.base_level = description_.provenance.base_level;
  options.block_bytes = description_.block_bytes;
  return options;
}

const BackendRegistry::Entry& StoredVersion::find_backend(const BackendRegistry& backends) const {
  const std::string& path = file_.path().native();
  try {
    const BackendRegistry::Entry& backend = backends.find(description_.backend);
    backend.validate(BackendRegistry::options_in(description_.backend));
    backend.validate_pipeline(description_.pipeline, {});
    for (const AttributeRecord& attribute : description_.attributes) {
      if (!is_derived(attribute.pipeline))
        backend.validate_pipeline(attribute.pipeline, attribute.schema);
      std::set<std::string_view> pipelines;
      if (is_derived(attribute.pipeline)) pipelines.insert(attribute.pipeline);
      for (const LevelRecord& level : attribute.levels) pipelines.insert(level.pipeline);
      for (const std::string_view pipeline : pipelines) {
        if (pipeline.find(';') != std::string_view::npos)
          throw Error(ErrorCode::kNotSupported,
                      fmt::format("expected one pipeline of a level, found \"{}\"", pipeline));
        if (!is_derived(pipeline))
          backend.validate_pipeline(pipeline, attribute.schema);
        else if (backends.derivations())
          backends.derivations()->source_of(derivation_in(pipeline), attribute.schema);
        else
          throw Error(ErrorCode::kNotSupported,
                      fmt::format("attribute '{}' is derived, and this program knows no rules",
                                  attribute.schema.name));
      }
    }
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
      read_base_mesh_file(file, {description_.base_mesh_bytes, description_.base_mesh_checksum});
  if (mesh.vertex_count() == description_.vertex_count &&
      mesh.edge_count() == description_.edge_count &&
      mesh.face_count() == description_.face_count &&
      mesh.border_edge_count() == description_.border_edge_count)
    return mesh;
  throw Error(ErrorCode::kCorruption,
              fmt::format("open {}: expected {} vertices, {} edges and {} faces, as {} says, found "
                          "{}, {} and {}",
                          file.path().native(), description_.vertex_count, description_.edge_count,
                          description_.face_count, version_name(), mesh.vertex_count(),
                          mesh.edge_count(), mesh.face_count()));
}

std::vector<StoredLevel> StoredVersion::levels(const BaseMesh& base) const {
  const int base_level = description_.provenance.base_level;
  std::vector<StoredLevel> levels;
  for (std::size_t at = 0; at < description_.attributes.size(); ++at) {
    const AttributeRecord& attribute = description_.attributes[at];
    for (std::size_t finer = 0; finer < attribute.levels.size(); ++finer) {
      StoredLevel& stored = levels.emplace_back();
      stored.attribute = at;
      stored.number = attribute.number;
      stored.level = base_level + 1 + static_cast<int>(finer);
      stored.record = attribute.levels[finer];
      try {
        const BaseRelativeLevel relative = relative_to_base(stored.level, base_level);
        stored.geometry =
            stored.is_derived()
                ? derived_geometry(base.slot_shapes(), relative.refinements,
                                   static_cast<int>(attribute.levels.size()),
                                   attribute.schema.record_bytes(), description_.block_bytes)
                : LevelGeometry(base.slot_shapes(), relative, attribute.schema.record_bytes(),
                                description_.block_bytes);
      } catch (const Error& error) {
        throw Error(ErrorCode::kCorruption,
                    fmt::format("open {}: attribute '{}': {}", file_.path().native(),
                                attribute.schema.name, error.what()));
      }
    }
  }
  return levels;
}

void StoredVersion::check_version_file() const {
  if (const std::uint64_t found = file_.size(); found != manifest_.version_bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", file_.path().native(), found,
                            manifest_.version_bytes));
  if (const std::uint64_t found = checksum_of(file_); found != manifest_.version_checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", file_.path().native(),
                            found, manifest_.version_checksum));
}

void StoredVersion::read_tables_into(std::span<StoredLevel> levels) const {
  check_version_file();
  std::uint64_t expected = 0;
  for (const StoredLevel& level : levels)
    if (!level.is_derived()) expected += level.geometry.block_count() * sizeof(BlockEntry);
  const std::uint64_t begin = block_tables_offset(description_bytes_.size());
  if (const std::uint64_t found = manifest_.version_bytes - begin; found != expected)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes of block tables, expected {}", file_.path().native(),
                            found, expected));
  std::vector<std::byte> bytes(expected);
  file_.read_at(begin, bytes);
  BlockTablesReader reader(bytes, file_.path());
  std::vector<BlockTable> tables;
  for (const StoredLevel& level : levels) {
    if (level.is_derived()) {
      tables.emplace_back();
      continue;
    }
    const std::vector<BlockEntry> entries = reader.next_level(level.geometry);
    BlockTable& table =
        tables.emplace_back(manifest_.uuid, level.number, level.level, entries.size());
    std::ranges::copy(entries, table.entries().begin());
  }
  reader.finish();
  for (std::size_t at = 0; at < levels.size(); ++at) levels[at].table = std::move(tables[at]);
}

std::vector<std::byte> StoredVersion::version_file_with(
    std::span<const BlockTable* const> tables) const {
  return encode_version_file(description_bytes_, tables);
}

std::vector<std::byte> StoredVersion::read_base_records(const AttributeRecord& attribute) const {
  const File file(store_, base_records_name(attribute), OpenMode::kRead);
  const std::string& path = file.path().native();
  const std::uint64_t bytes = description_.vertex_count * attribute.schema.record_bytes();
  if (file.size() != bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", path, file.size(), bytes));
  std::vector<std::byte> records(bytes);
  file.read_at(0, records);
  if (const std::uint64_t found = checksum_of(records); found != attribute.base_checksum)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: checksum {:016x}, expected {:016x}",
                                                    path, found, attribute.base_checksum));
  return records;
}

std::string StoredVersion::version_name() const { return version_file_name(manifest_.sequence); }

std::string StoredVersion::base_records_name(const AttributeRecord& attribute) const {
  return base_file_name(attribute.number, manifest_.sequence);
}

std::set<std::string> StoredVersion::file_names() const {
  std::set<std::string> names = {version_name()};
  for (const AttributeRecord& attribute : description_.attributes) {
    if (is_derived(attribute.pipeline)) continue;
    names.insert(base_records_name(attribute));
    int level = description_.provenance.base_level;
    for (const LevelRecord& record : attribute.levels)
      names.insert(level_file_name(attribute.number, ++level, record.generation));
  }
  return names;
}

PLAIT_END_NAMESPACE
