// A committed version as the files of a store have it: the one reader of them. Each call reads and
// checks one file, believes nothing, and throws; who wants to know of all that is wrong goes on
// with the next call. Bytes: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "plait/backend.h"
#include "plait/base_mesh.h"
#include "plait/block_table.h"
#include "plait/directory.h"
#include "plait/file.h"
#include "plait/level_geometry.h"
#include "plait/options.h"
#include "store/file_names.h"
#include "store/manifest.h"
#include "store/version_description.h"
#include "store/version_locks.h"

namespace plait {

/// One level of one attribute: what its file should be.
struct StoredLevel {
  std::size_t attribute = 0;  ///< position in VersionDescription::attributes
  std::uint32_t number = 0;   ///< the attribute's, in file names and checksums
  int level = 0;
  LevelRecord record;
  LevelGeometry geometry;
  BlockTable table;

  std::string file_name() const { return level_file_name(number, level, record.generation); }
};

class StoredVersion {
 public:
  /// `store` outlives this object. Errors: kCorruption, kNotSupported, kIo for version.S.
  StoredVersion(const Directory& store, OpenVersion version);

  const Manifest& manifest() const { return manifest_; }
  const VersionDescription& description() const { return description_; }
  /// As the description says; what it does not say is as it is by default.
  StoreOptions options() const;
  /// Errors: kNotSupported for a backend, options or pipelines that are not there; kCorruption for
  /// a backend that keeps nothing on disk.
  const BackendRegistry::Entry& find_backend(const BackendRegistry& backends) const;

  /// Errors: kNotFound, kCorruption, also for counts that are not the description's; kIo.
  BaseMesh read_base_mesh() const;
  /// Every level, attributes in the description's order, with no block written. `base` outlives
  /// them. Errors: kCorruption for a level that is too large to be.
  std::vector<StoredLevel> levels(const BaseMesh& base) const;
  /// Whether version.S is what the manifest says. Errors: kCorruption, kIo.
  void check_version_file() const;
  /// Enters what version.S says of every level, each entry in its range.
  /// Errors: kCorruption, and then no level is changed; kIo.
  void read_tables_into(std::span<StoredLevel> levels) const;
  /// The bytes that version.S has if these are the tables of its levels.
  std::vector<std::byte> version_file_with(std::span<const BlockTable* const> tables) const;
  /// Of an attribute in the description. Errors: kNotFound, kCorruption, kIo.
  std::vector<std::byte> read_base_records(const AttributeRecord& attribute) const;

  std::string version_name() const;
  std::string base_records_name(const AttributeRecord& attribute) const;
  /// Of all files that belong to this version alone or with others, but for the base mesh.
  std::set<std::string> file_names() const;
  /// version.S, with the reader's lock where there is one. No other call after this.
  File release_file() && { return std::move(file_); }

 private:
  const Directory& store_;
  Manifest manifest_;
  File file_;  ///< version.S
  std::vector<std::byte> description_bytes_;
  VersionDescription description_;
};

}  // namespace plait
