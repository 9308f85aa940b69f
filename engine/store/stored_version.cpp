#include "store/stored_version.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "plait/error.h"
#include "plait/file.h"
#include "store/base_mesh_file.h"
#include "store/block_tables_file.h"
#include "store/checksum.h"
#include "store/file_names.h"

namespace plait {

StoredVersion::StoredVersion(const Directory& store)
    : store_(store), manifest_(read_manifest(store)) {}

StoreOptions StoredVersion::options() const {
  StoreOptions options;
  options.backend = manifest_.backend;
  options.backend_options = {manifest_.codec, manifest_.filter};
  options.layout = manifest_.layout;
  options.base_level = manifest_.base_level;
  options.block_bytes = manifest_.block_bytes;
  return options;
}

const BackendRegistry::Entry& StoredVersion::find_backend(const BackendRegistry& backends) const {
  const std::string path = store_.path_of(kManifestName).native();
  try {
    const BackendRegistry::Entry& backend = backends.find(manifest_.backend);
    backend.validate({manifest_.codec, manifest_.filter});
    if (backend.traits.durable) return backend;
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("open {}: {}", path, error.what()));
  }
  throw Error(ErrorCode::kCorruption,
              fmt::format("open {}: backend '{}' keeps nothing on disk", path, manifest_.backend));
}

BaseMesh StoredVersion::read_base_mesh() const {
  const File file(store_, kBaseMeshName, OpenMode::kRead);
  BaseMesh mesh =
      read_base_mesh_file(file, {manifest_.base_mesh_bytes, manifest_.base_mesh_checksum});
  if (mesh.vertex_count() == manifest_.vertex_count && mesh.edge_count() == manifest_.edge_count &&
      mesh.face_count() == manifest_.face_count &&
      mesh.border_edge_count() == manifest_.border_edge_count)
    return mesh;
  throw Error(
      ErrorCode::kCorruption,
      fmt::format("open {}: expected the manifest's {} vertices, {} edges and {} faces, "
                  "found {}, {} and {}",
                  file.path().native(), manifest_.vertex_count, manifest_.edge_count,
                  manifest_.face_count, mesh.vertex_count(), mesh.edge_count(), mesh.face_count()));
}

std::vector<StoredLevel> StoredVersion::levels(const BaseMesh& base) const {
  std::vector<StoredLevel> levels;
  for (std::size_t at = 0; at < manifest_.attributes.size(); ++at) {
    const ManifestAttribute& attribute = manifest_.attributes[at];
    for (int level = manifest_.base_level + 1; level <= attribute.finest_level; ++level) {
      StoredLevel& stored = levels.emplace_back();
      stored.attribute = at;
      stored.number = attribute.number;
      stored.level = level;
      try {
        stored.geometry =
            LevelGeometry(base.slot_shapes(), relative_to_base(level, manifest_.base_level),
                          attribute.schema.record_bytes(), manifest_.block_bytes);
      } catch (const Error& error) {
        throw Error(ErrorCode::kCorruption, fmt::format("open {}: attribute '{}': {}",
                                                        store_.path_of(kManifestName).native(),
                                                        attribute.schema.name, error.what()));
      }
    }
  }
  return levels;
}

std::vector<std::byte> StoredVersion::read_tables() const {
  return read_whole(tables_name(), manifest_.tables_bytes, manifest_.tables_checksum);
}

void StoredVersion::read_tables_into(std::span<StoredLevel> levels) const {
  const std::vector<std::byte> bytes = read_tables();
  BlockTablesReader reader(bytes, store_.path_of(tables_name()));
  std::vector<BlockTable> tables;
  for (const StoredLevel& level : levels) {
    const std::vector<BlockEntry> entries = reader.next_level(level.geometry);
    BlockTable& table =
        tables.emplace_back(manifest_.uuid, level.number, level.level, entries.size());
    std::ranges::copy(entries, table.entries().begin());
  }
  reader.finish();
  for (std::size_t at = 0; at < levels.size(); ++at) levels[at].table = std::move(tables[at]);
}

std::vector<std::byte> StoredVersion::read_base_records(const ManifestAttribute& attribute) const {
  return read_whole(base_records_name(attribute),
                    manifest_.vertex_count * attribute.schema.record_bytes(),
                    attribute.base_checksum);
}

std::string StoredVersion::tables_name() const { return tables_file_name(manifest_.sequence); }

std::string StoredVersion::base_records_name(const ManifestAttribute& attribute) const {
  return base_file_name(attribute.number, manifest_.sequence);
}

std::vector<std::byte> StoredVersion::read_whole(const std::string& name, std::uint64_t bytes,
                                                 std::uint64_t checksum) const {
  const File file(store_, name, OpenMode::kRead);
  const std::string& path = file.path().native();
  if (file.size() != bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", path, file.size(), bytes));
  std::vector<std::byte> content(bytes);
  file.read_at(0, content);
  if (const std::uint64_t found = checksum_of(content); found != checksum)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: checksum {:016x}, expected {:016x}", path, found, checksum));
  return content;
}

std::set<std::string> version_file_names(const Manifest& manifest) {
  std::set<std::string> names = {tables_file_name(manifest.sequence)};
  for (const ManifestAttribute& attribute : manifest.attributes) {
    names.insert(base_file_name(attribute.number, manifest.sequence));
    for (int level = manifest.base_level + 1; level <= attribute.finest_level; ++level)
      names.insert(level_file_name(attribute.number, level));
  }
  return names;
}

}  // namespace plait
