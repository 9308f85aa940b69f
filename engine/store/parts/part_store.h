// The store of one part: a Store that makes levels of which it has one shard of a larger store. A
// machine makes it, and another puts the shards of all parts together (store/version_writer.h).
// It is never committed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "format/base_mesh_file.h"
#include "format/version_description.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/store.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Which shard of which store.
struct PartOfStore {
  StoreUuid uuid{};
  EdgeShards shards;
  std::uint32_t shard = 0;
  StoredSize base_mesh = {};  ///< of the store's file base.mesh
  bool shares_files = false;  ///< as in VersionDescription
};

/// Makes a store whose levels have only the slots of one shard. `directory` exists and is empty;
/// files of levels go there, and no other file. `base` may be around() the edges of the shard for a
/// scheme of one ring. subdivide() fills it with the fused executor; only records of base vertices
/// that owned_vertices() names are then right. Errors: as Store::create.
Store create_part_store(const std::filesystem::path& directory, BaseMesh base,
                        const StoreOptions& options, const BackendRegistry& backends,
                        const Provenance& provenance, PartOfStore part);

/// A part of a pass over a store in shards.
struct PartOfVersion {
  std::uint32_t shard = 0;
  std::filesystem::path directory;  ///< for what the part makes; empty
  /// Called with the version that is there, before more of it is read. Throws if it is another than
  /// the pass reads, or has no such shard.
  std::function<void(const StoredVersion&)> check;
};

/// Opens the last commit of a store in shards for a pass that makes one shard of the next version.
/// All attributes of the commit are there with all shards, and can only be read. Attributes that
/// are added have levels with the slots of one shard, whose files are in `part.directory`; of their
/// base records only those of owned_vertices() are then right. Such an attribute may replace
/// another one. A sweep works on the edges of the shard. `options`: of the memory and the threads.
/// Errors: as Store::open; those of `part.check`.
Store open_part_store(const std::filesystem::path& path, const PartOfVersion& part,
                      const OpenOptions& options, const BackendRegistry& backends);

/// The shard that has a base vertex: that of the lowest edge of the face with the vertex's first
/// corner. So the shard computes that face.
std::uint32_t owner_of(const Topology& mesh, const EdgeShards& shards, VertexId vertex);

/// The base vertices that the shard has, ascending. `mesh` is the whole one or around() the edges
/// of the shard.
std::vector<VertexId> owned_vertices(const BaseMesh& mesh, const EdgeShards& shards,
                                     std::uint32_t shard);

/// What is in the files of a finished part.
struct PartContent {
  /// Of the version that the parts make, without the shards and the checksums of base records that
  /// it makes.
  VersionDescription description;
  std::vector<std::byte> tables;  ///< the file tables_file_name(version, shard)
  /// Of owned_vertices(), of one attribute after another that the part makes.
  std::vector<std::byte> base_records;
  struct FileOfPart {
    std::string name;
    std::uint64_t bytes = 0;
  };
  std::vector<FileOfPart> files;  ///< of the levels that it makes, in the order of the tables
};

/// Writes all blocks and, with kCommit, syncs the files of the levels. Errors: kBadState for an
/// unfinished level; kIo, kNoSpace.
PartContent finish_part_store(Store& store);

PLAIT_END_NAMESPACE
