// Reads the files of a committed version. No other code reads them. Each call reads one file,
// checks all its bytes, and throws if they are wrong. A caller that wants to find all damage
// continues with the next call. Bytes: docs/format.md.
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
#include "plait/derivation.h"
#include "plait/directory.h"
#include "plait/file.h"
#include "plait/level_geometry.h"
#include "plait/options.h"
#include "store/file_names.h"
#include "store/manifest.h"
#include "store/version_description.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// One level of one attribute, as the description says it should be.
struct StoredLevel {
  std::size_t attribute = 0;  ///< position in VersionDescription::attributes
  std::uint32_t number = 0;   ///< the attribute's number in file names and checksums
  int level = 0;
  LevelRecord record;
  LevelGeometry geometry;
  BlockTable table;

  /// It has no file and no table.
  bool is_derived() const { return plait::is_derived(record.pipeline); }
  std::string file_name() const { return level_file_name(number, level, record.generation); }
};

class StoredVersion {
 public:
  /// `store` must outlive this object. Errors: kCorruption, kNotSupported, kIo for version.S.
  StoredVersion(const Directory& store, OpenVersion version);

  const Manifest& manifest() const { return manifest_; }
  const VersionDescription& description() const { return description_; }
  /// The options that the description records; all others have their defaults.
  StoreOptions options() const;
  /// Errors: kNotSupported for an unknown backend, or for options or pipelines that it cannot use;
  /// kCorruption for a backend that writes no files.
  const BackendRegistry::Entry& find_backend(const BackendRegistry& backends) const;

  /// Errors: kNotFound; kCorruption, also if the counts differ from those of the description; kIo.
  BaseMesh read_base_mesh() const;
  /// All levels, with attributes in the description's order. All blocks are marked as never
  /// written. `base` must outlive the result. Errors: kCorruption for a level that is too large for
  /// a file.
  std::vector<StoredLevel> levels(const BaseMesh& base) const;
  /// Throws unless version.S has the size and the checksum that the manifest records. Errors:
  /// kCorruption, kIo.
  void check_version_file() const;
  /// Reads the block tables of all stored levels from version.S, and checks that each entry is in
  /// its range. Errors: kCorruption, and then no level is changed; kIo.
  void read_tables_into(std::span<StoredLevel> levels) const;
  /// The bytes that version.S would have with these tables.
  std::vector<std::byte> version_file_with(std::span<const BlockTable* const> tables) const;
  /// Reads the base records of an attribute in the description. Errors: kNotFound, kCorruption,
  /// kIo.
  std::vector<std::byte> read_base_records(const AttributeRecord& attribute) const;

  std::string version_name() const;
  std::string base_records_name(const AttributeRecord& attribute) const;
  /// The names of all files that this version needs, except the base mesh.
  std::set<std::string> file_names() const;
  /// Returns the open file version.S, with the reader's lock if it has one. No other function may
  /// be called after this.
  File release_file() && { return std::move(file_); }

 private:
  const Directory& store_;
  Manifest manifest_;
  File file_;  ///< version.S
  std::vector<std::byte> description_bytes_;
  VersionDescription description_;
};

PLAIT_END_NAMESPACE
