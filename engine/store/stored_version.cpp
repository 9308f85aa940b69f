#include "store/stored_version.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "format/base_mesh_file.h"
#include "format/depths_file.h"
#include "format/file_names.h"
#include "format/version_file.h"
#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/block_maker.h"
#include "plait/extend/file.h"
#include "store/parts/shard_place.h"
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
