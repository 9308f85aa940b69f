// plait/extend/check_store.h: checks each file of a committed version of a store by itself, without
// the content of blocks. Store::open throws at the first bad file; check_store() names all of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/pager.h"
#include "plait/options.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

enum class StoreFile : std::uint8_t {
  kDescription,  ///< version.S; nothing else of the version is known
  kBaseMesh,
  kDepths,       ///< the file "depths", which says where slots are
  kBaseIndex,    ///< base.index, which a store may be without
  kBlockTables,  ///< version.S; its description is whole
  kChangeLog,    ///< changes.G; its records, and blocks beyond its end
  kBaseRecords,
  kFaceRecords,
  kLevel,
};

/// A file that the version needs, and that is missing or damaged.
struct DamagedFile {
  StoreFile kind = StoreFile::kLevel;
  std::string name;       ///< in the store's directory
  std::string attribute;  ///< records and levels: whose
  int level = 0;          ///< levels: which
  std::size_t file = 0;   ///< levels: the shard; 0 for a level in one piece
  std::string reason;
  std::uint64_t expected_bytes = 0, expected_checksum = 0;  ///< all but levels
  /// Levels: the geometry and the checksums that the level should have, without a backend; nullptr
  /// if base mesh or block tables are damaged too.
  std::unique_ptr<LevelFile> expected_level;
};

/// What check_store() found.
struct StoreCheck {
  std::uint64_t sequence = 0;  ///< of the version that Store::open takes
  std::uint64_t files = 0;     ///< looked at, good or bad
  StoreOptions options;        ///< as the manifest says
  Provenance provenance;
  std::vector<AttributeInfo> attributes;
  BaseMesh base;                         ///< empty if base.mesh is damaged; with its depths
  bool depths_lost = false;              ///< `base` is without them: their file is damaged
  std::uint64_t base_mesh_checksum = 0;  ///< of base.mesh, as the version says
  bool in_shards = false;                ///< the levels are in shards
  std::vector<DamagedFile> damaged;
  std::vector<std::string> left_over;  ///< names in the directory that no version refers to
  std::vector<std::string> notes;      ///< harmless faults, such as a bad manifest slot
  std::string lock;                    ///< why no writer can use the store's lock; empty if one can
};

/// Checks manifest, description, base mesh, base records and block tables with their checksums, and
/// of each level file size and extents as its backend sees them. Holds the reader's lock meanwhile.
/// Errors: as Store::open for what concerns the whole store (no such directory, no whole manifest,
/// an unknown backend, somebody writing); kIo.
StoreCheck check_store(const std::filesystem::path& path, const BackendRegistry& backends);

/// What a version says of itself.
struct StoreDescription {
  /// An attribute, and how its levels are encoded.
  struct Attribute {
    AttributeSchema schema;
    int finest_level = 0;
    std::vector<Pipeline> pipelines;  ///< [level - base level - 1]
  };
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  StoreOptions options;  ///< backend, pipeline and block size
  Provenance provenance;
  std::uint64_t vertex_count = 0, edge_count = 0, face_count = 0, border_edge_count = 0;
  std::vector<Attribute> attributes;
  std::vector<AttributeSchema> face_attributes;
  Texts texts;
};
/// Reads the newest version's description, and no other part of it. So it works also for a store
/// whose backend, codec or filter this program does not have. Errors: as Store::open.
StoreDescription describe_store(const std::filesystem::path& path);

PLAIT_END_NAMESPACE
