// plait/check_store.h: the files that a committed version of a store consists of, each checked by
// itself and without the content of blocks. Where Store::open ends at the first bad one, this names
// all of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/backend.h"
#include "plait/base_mesh.h"
#include "plait/namespace.h"
#include "plait/options.h"
#include "plait/pager.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

enum class StoreFile : std::uint8_t {
  kDescription,  ///< version.S, so that nothing else of the version is known
  kBaseMesh,
  kBlockTables,  ///< version.S, whose description is whole
  kBaseRecords,
  kLevel,
};

/// A file that the version needs and that is not what the manifest says.
struct DamagedFile {
  StoreFile kind = StoreFile::kLevel;
  std::string name;       ///< in the store's directory
  std::string attribute;  ///< base records and levels: whose
  int level = 0;          ///< levels: which
  std::string reason;
  std::uint64_t expected_bytes = 0, expected_checksum = 0;  ///< all but levels
  /// Levels: geometry and seals of what should be there, without a backend; nullptr where base mesh
  /// or block tables are damaged too.
  std::unique_ptr<LevelFile> expected_level;
};

/// What check_store() found.
struct StoreCheck {
  std::uint64_t sequence = 0;  ///< of the version that Store::open takes
  std::uint64_t files = 0;     ///< looked at, good or bad
  StoreOptions options;        ///< as the manifest says
  Provenance provenance;
  std::vector<AttributeInfo> attributes;
  BaseMesh base;  ///< empty if base.mesh is damaged
  std::vector<DamagedFile> damaged;
  std::vector<std::string> left_over;  ///< names in the directory that no version refers to
  std::vector<std::string> notes;      ///< what is odd and does no harm: a bad manifest slot
};

/// Checks manifest, description, base mesh, base records and block tables with their checksums, and
/// of each level file size and extents as its backend sees them. Holds the reader's lock meanwhile.
/// Errors: as Store::open for what concerns the whole store (no such directory, no whole manifest,
/// an unknown backend, somebody writing); kIo.
StoreCheck check_store(const std::filesystem::path& path, const BackendRegistry& backends);

PLAIT_END_NAMESPACE
