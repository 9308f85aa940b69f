// A committed version as the files of a store have it: the one reader of them. Each call reads and
// checks one file, believes nothing, and throws; who wants to know of all that is wrong goes on
// with the next call. Bytes: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "plait/backend.h"
#include "plait/base_mesh.h"
#include "plait/block_table.h"
#include "plait/directory.h"
#include "plait/level_geometry.h"
#include "plait/options.h"
#include "store/manifest.h"

namespace plait {

/// One level of one attribute: what its file should be.
struct StoredLevel {
  std::size_t attribute = 0;  ///< position in Manifest::attributes
  std::uint32_t number = 0;   ///< the attribute's, in file names and checksums
  int level = 0;
  LevelGeometry geometry;
  BlockTable table;
};

class StoredVersion {
 public:
  /// The newest version. `store` outlives this object. Errors: those of read_manifest.
  explicit StoredVersion(const Directory& store);

  const Manifest& manifest() const { return manifest_; }
  /// As the manifest says; what it does not say is as it is by default.
  StoreOptions options() const;
  /// Errors: kNotSupported for a backend or options that are not there; kCorruption for one that
  /// keeps nothing on disk.
  const BackendRegistry::Entry& find_backend(const BackendRegistry& backends) const;

  /// Errors: kNotFound, kCorruption, also for counts that are not the manifest's; kIo.
  BaseMesh read_base_mesh() const;
  /// Every level, attributes in manifest order, with no block written. `base` outlives them.
  /// Errors: kCorruption for a level that is too large to be.
  std::vector<StoredLevel> levels(const BaseMesh& base) const;
  /// The bytes of tables.S. Errors: kNotFound, kCorruption for a wrong size or checksum, kIo.
  std::vector<std::byte> read_tables() const;
  /// Enters what tables.S says of every level, each entry in its range.
  /// Errors: kNotFound, kCorruption, and then no level is changed; kIo.
  void read_tables_into(std::span<StoredLevel> levels) const;
  /// Of an attribute in the manifest. Errors: kNotFound, kCorruption, kIo.
  std::vector<std::byte> read_base_records(const ManifestAttribute& attribute) const;

  std::string tables_name() const;
  std::string base_records_name(const ManifestAttribute& attribute) const;

 private:
  std::vector<std::byte> read_whole(const std::string& name, std::uint64_t bytes,
                                    std::uint64_t checksum) const;

  const Directory& store_;
  Manifest manifest_;
};

/// Names of the files that belong to this version alone or with others: base records, block tables
/// and levels.
std::set<std::string> version_file_names(const Manifest& manifest);

}  // namespace plait
