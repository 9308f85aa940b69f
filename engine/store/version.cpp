// Writing and reading one committed version: tables, base records, manifest slot.
#include <fmt/format.h>

#include "plait/error.h"
#include "store/block_tables_file.h"
#include "store/checksum.h"
#include "store/file_names.h"
#include "store/store_state.h"
#include "store/stored_geometry.h"

namespace plait {
namespace {

/// Creates the file anew, whatever an earlier run left under its name.
void write_whole_file(const Directory& store, const std::string& name,
                      std::span<const std::byte> bytes, bool durable) {
  store.remove(name);
  File file(store, name, OpenMode::kCreate);
  file.write_at(0, bytes);
  if (durable) file.sync();
  file.close();
}

std::vector<std::byte> read_whole_file(const Directory& store, const std::string& name,
                                       std::uint64_t bytes, std::uint64_t checksum) {
  const File file(store, name, OpenMode::kRead);
  const std::filesystem::path& path = file.path();
  if (file.size() != bytes)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: {} bytes, expected {}", path.native(), file.size(), bytes));
  std::vector<std::byte> content(bytes);
  file.read_at(0, content);
  if (const std::uint64_t found = checksum_of(content); found != checksum)
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: checksum {:016x}, expected {:016x}",
                                                    path.native(), found, checksum));
  return content;
}

}  // namespace

std::vector<std::byte> encode_tables(const Store::Implementation& store) {
  std::vector<std::byte> bytes = block_tables_header();
  for (const auto& attribute : store.attributes)
    for (const auto& level : attribute.levels) {
      const auto entries = std::as_bytes(level->table.entries());
      bytes.insert(bytes.end(), entries.begin(), entries.end());
    }
  return bytes;
}

Manifest Store::Implementation::manifest() const {
  Manifest result;
  result.uuid = uuid;
  result.sequence = sequence;
  result.vertex_count = base.vertex_count();
  result.edge_count = base.edge_count();
  result.face_count = base.face_count();
  result.border_edge_count = base.border_edge_count();
  result.block_bytes = options.block_bytes;
  result.base_level = options.base_level;
  result.next_attribute_number = next_number;
  result.base_mesh_bytes = base_mesh_size.bytes;
  result.base_mesh_checksum = base_mesh_size.checksum;
  result.backend = options.backend;
  result.codec = options.backend_options.codec;
  result.filter = options.backend_options.filter;
  result.layout = options.layout;
  result.scheme = options.scheme;
  for (std::size_t i = 0; i < attributes.size(); ++i)
    result.attributes.push_back({infos[i].schema, attributes[i].number, infos[i].finest_level, 0});
  return result;
}

void Store::Implementation::write_version() {
  const bool durable = options.durability == Durability::kCommit;
  for (const Attribute& attribute : attributes)
    for (const auto& level : attribute.levels) level->backend->sync(durable);

  Manifest next = manifest();
  ++next.sequence;
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    write_whole_file(directory, base_file_name(attributes[i].number, next.sequence),
                     attributes[i].base_bytes, durable);
    next.attributes[i].base_checksum = checksum_of(attributes[i].base_bytes);
  }
  const std::vector<std::byte> tables = encode_tables(*this);
  write_whole_file(directory, tables_file_name(next.sequence), tables, durable);
  next.tables_bytes = tables.size();
  next.tables_checksum = checksum_of(tables);
  if (durable) directory.sync();

  File file(directory, kManifestName, OpenMode::kReadWrite);
  write_manifest(file, next);
  if (durable) file.sync();
  file.close();
  if (durable && !name_is_durable) {
    directory.parent().sync();
    name_is_durable = true;
  }

  // From here on the version is there, whatever becomes of what is no longer needed.
  if (journal) journal->begin_version(next.sequence);
  if (sequence > 0) {
    directory.remove_if_possible(tables_file_name(sequence - 1));
    for (const Attribute& attribute : attributes)
      directory.remove_if_possible(base_file_name(attribute.number, sequence - 1));
  }
  for (const std::string& name : obsolete) directory.remove_if_possible(name);
  obsolete.clear();
  sequence = next.sequence;
}

void Store::Implementation::read_version(const Manifest& manifest, OpenMode mode) {
  const std::filesystem::path manifest_path = directory.path_of(kManifestName);
  if (base.vertex_count() != manifest.vertex_count || base.edge_count() != manifest.edge_count ||
      base.face_count() != manifest.face_count ||
      base.border_edge_count() != manifest.border_edge_count)
    throw Error(ErrorCode::kCorruption,
                fmt::format("open {}: its counts are not those of base.mesh ({} vertices, {} "
                            "edges, {} faces)",
                            manifest_path.native(), base.vertex_count(), base.edge_count(),
                            base.face_count()));
  const std::string tables_name = tables_file_name(manifest.sequence);
  const std::vector<std::byte> tables =
      read_whole_file(directory, tables_name, manifest.tables_bytes, manifest.tables_checksum);
  BlockTablesReader tables_reader(tables, directory.path_of(tables_name));

  for (const ManifestAttribute& stored : manifest.attributes) {
    Attribute attribute;
    attribute.number = stored.number;
    attribute.base_bytes =
        read_whole_file(directory, base_file_name(stored.number, manifest.sequence),
                        base.vertex_count() * stored.schema.record_bytes(), stored.base_checksum);
    for (int level = manifest.base_level + 1; level <= stored.finest_level; ++level) {
      const LevelGeometry geometry = stored_geometry(manifest, base, stored, level, manifest_path);
      const std::vector<BlockEntry> entries = tables_reader.next_level(geometry);
      attribute.levels.push_back(open_level(attribute, stored.schema, level, mode, entries));
    }
    infos.push_back({stored.schema, stored.finest_level});
    attributes.push_back(std::move(attribute));
  }
  tables_reader.finish();
}

}  // namespace plait
