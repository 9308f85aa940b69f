// The store of one part: a Store whose levels are one shard of a larger store. A machine makes it,
// and another puts the shards of all parts together (store/joined_store.h). It is never committed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "format/base_mesh_file.h"
#include "format/version_description.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Which shard of which store.
struct PartOfStore {
  StoreUuid uuid{};
  EdgeShards shards;
  std::uint32_t shard = 0;
  StoredSize base_mesh = {};  ///< of the store's file base.mesh
};

/// Makes a store whose levels have only the slots of one shard. `directory` exists and is empty;
/// files of levels go there, and no other file. subdivide() fills it with the fused executor; only
/// records of base vertices that owned_vertices() names are then right. Errors: as Store::create.
Store create_part_store(const std::filesystem::path& directory, BaseMesh base,
                        const StoreOptions& options, const BackendRegistry& backends,
                        const Provenance& provenance, PartOfStore part);

/// The shard that has a base vertex: that of the lowest edge of the face with the vertex's first
/// corner. So the shard computes that face.
std::uint32_t owner_of(const Topology& mesh, const EdgeShards& shards, VertexId vertex);

/// The base vertices that the shard has, ascending.
std::vector<VertexId> owned_vertices(const Topology& mesh, const EdgeShards& shards,
                                     std::uint32_t shard);

/// What is in the files of a finished part.
struct PartContent {
  VersionDescription description;       ///< of version 1, without checksums of base records
  std::vector<std::byte> tables;        ///< the file tables_file_name(1, shard)
  std::vector<std::byte> base_records;  ///< attribute after attribute, of owned_vertices()
  struct LevelOfPart {
    std::string name;
    std::uint64_t bytes = 0;
  };
  std::vector<LevelOfPart> levels;  ///< the files, in the order of the tables
};

/// Writes all blocks and, with kCommit, syncs the files of the levels. Errors: kBadState for an
/// unfinished level; kIo, kNoSpace.
PartContent finish_part_store(Store& store);

PLAIT_END_NAMESPACE
