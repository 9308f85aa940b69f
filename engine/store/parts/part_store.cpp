#include "store/parts/part_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "mesh/mesh_region.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "store/parts/shard_tables.h"
#include "store/recovery.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Whether the part makes the attribute, and does not only read it.
bool is_made_by_part(const Store::Implementation& state,
                     const Store::Implementation::Attribute& of) {
  return of.record.number >= state.first_made;
}

}  // namespace

Store create_part_store(const std::filesystem::path& directory, BaseMesh base,
                        const StoreOptions& options, const BackendRegistry& backends,
                        const Provenance& provenance, PartOfStore part) try {
  auto state = std::make_unique<Store::Implementation>();
  state->options = options;
  state->backend = backends.find(options.backend);
  state->backend.check_machine();
  state->base = std::move(base);
  if (!options.pipeline) state->options.pipeline = state->backend.default_pipeline;
  state->backend.check_pipelines(*state->options.pipeline, {});
  state->uuid = part.uuid;
  state->shards = std::move(part.shards);
  state->only_shard = part.shard;
  state->base_mesh_size = part.base_mesh;
  state->shares_files = part.shares_files;
  state->writable = true;
  state->provenance = state->first_provenance = provenance;
  state->path = directory;
  state->directory = Directory(directory);
  state->make_ready();
  return StoreAccess::store_of(std::move(state));
} catch (const std::bad_alloc&) {
  throw out_of_memory("create " + directory.native());
}

Store open_part_store(const std::filesystem::path& path, const PartOfVersion& part,
                      const OpenOptions& options, const BackendRegistry& backends) try {
  auto state = std::make_unique<Store::Implementation>();
  state->path = path;
  state->directory = open_store_directory(path);
  StoredVersion version(state->directory, open_for_reading(state->directory));
  part.check(version);
  state->open_version(version, options, backends);
  state->only_shard = part.shard;
  state->made_in = Directory(part.directory);
  state->writable = true;
  state->version_file = std::move(version).release_file();
  return StoreAccess::store_of(std::move(state));
} catch (const std::bad_alloc&) {
  throw out_of_memory("open " + path.native());
}

std::uint32_t owner_of(const Topology& mesh, const EdgeShards& shards, VertexId vertex) {
  return shards.shard_of(
      *std::ranges::min_element(mesh.face_edges[mesh.vertex_corners[vertex].face()]));
}

std::vector<VertexId> owned_vertices(const BaseMesh& mesh, const EdgeShards& shards,
                                     std::uint32_t shard) {
  const Topology topology = mesh.topology();
  const VerticesAtHand candidates = walkable_vertices(mesh);
  std::vector<VertexId> vertices;
  for (std::size_t at = 0; at < candidates.size(); ++at)
    if (owner_of(topology, shards, candidates[at]) == shard) vertices.push_back(candidates[at]);
  return vertices;
}

PartContent finish_part_store(Store& store) {
  Store::Implementation& state = StoreAccess::state(store);
  check_change(state, Change::kCommit, "finish the part");
  state.pager->flush();
  PartContent content;
  std::vector<BlockTable> tables;
  for (std::size_t at = 0; at < state.attributes.size(); ++at) {
    if (const WrittenRecords& base = *state.attributes[at].base_written; !base.is_finished())
      refuse_unfinished(state, state.infos[at].schema.name, base, state.provenance.base_level);
    for (const auto& level : state.attributes[at].levels) {
      if (!is_made_by_part(state, state.attributes[at])) {
        const LevelGeometry& geometry = level->geometry;
        const std::uint64_t first = geometry.first_block(state.only_shard);
        tables.push_back(
            level->table.part(first, geometry.first_block(state.only_shard + 1) - first));
        continue;
      }
      if (!level->is_finished())
        refuse_unfinished(state, state.infos[at].schema.name, *level, level->table.level());
      level->backend->sync(state.options.durability == Durability::kCommit);
      tables.push_back(level->table);
      std::string name = level->path.filename().string();
      if (!content.files.empty() && content.files.back().name == name) continue;
      const std::uint64_t bytes =
          File(state.in_shards ? state.made_in : state.directory, name, OpenMode::kRead).size();
      content.files.push_back({std::move(name), bytes});
    }
  }
  content.description = state.description();
  content.tables = encode_shard_tables(state.uuid, state.only_shard, tables);
  const std::vector<VertexId> owned = owned_vertices(state.base, state.shards, state.only_shard);
  for (std::size_t at = 0; at < state.attributes.size(); ++at) {
    if (!is_made_by_part(state, state.attributes[at])) continue;
    const std::size_t record_bytes = state.infos[at].schema.record_bytes();
    const std::span<const std::byte> records = state.attributes[at].base_bytes;
    for (const VertexId vertex : owned) {
      const auto record = records.subspan(vertex * record_bytes, record_bytes);
      content.base_records.insert(content.base_records.end(), record.begin(), record.end());
    }
  }
  return content;
}

PLAIT_END_NAMESPACE
