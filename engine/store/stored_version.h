// Reads the files of a committed version. No other code reads them. Each call reads one file,
// checks all its bytes, and throws if they are wrong. A caller that wants to find all damage
// continues with the next call. Bytes: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/zeroed_array.h"
#include "format/base_index_file.h"
#include "format/change_record.h"
#include "format/file_names.h"
#include "format/manifest.h"
#include "format/version_description.h"
#include "plait/base_mesh.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/level_geometry.h"
#include "plait/options.h"
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
  std::uint32_t shards = 0;   ///< 0: the level is in one piece
  bool shares_files = false;  ///< as in VersionDescription

  /// The name of its file. A level in shards has one file for each shard, alone or with the
  /// attribute's other levels.
  std::vector<std::string> file_names() const;
};

class StoredVersion {
 public:
  /// `store` must outlive this object. Errors: kCorruption, kNotSupported, kIo for version.S;
  /// kCorruption if the files that are read whole are nearly all holes.
  StoredVersion(const Directory& store, OpenVersion version);

  const Manifest& manifest() const { return manifest_; }
  const VersionDescription& description() const { return description_; }
  /// The options that the description records; all others have their defaults.
  StoreOptions options() const;
  /// Errors: kNotSupported for an unknown backend, or for options or pipelines that it cannot use;
  /// kCorruption for a backend that writes no files.
  const RegisteredBackend& find_backend(const BackendRegistry& backends) const;

  /// Throws if base mesh or base records have other sizes than version.S says. Errors: kCorruption.
  void check_base_sizes() const;
  /// Builds the mesh from base.mesh. Errors: kNotFound; kCorruption, also if the counts differ from
  /// those of the description; kIo.
  BaseMesh read_base_mesh() const;
  /// `base` with the depths of the faces, or `base` itself if the version has none. Errors:
  /// kNotFound; kCorruption for a file of another size, checksum or number of slots; kIo.
  BaseMesh with_depths(BaseMesh base) const;
  /// The mesh of base.index, which reads that file when it is needed; nothing if there is no such
  /// file. Errors: kCorruption, kIo.
  std::optional<BaseMesh> open_base_index() const;
  /// Throws kCorruption unless base.index has what follows from `base`, or from any mesh without
  /// it, or is not there. Errors: kIo.
  void check_base_index(const BaseMesh* base) const;
  /// All levels, with attributes in the description's order. All blocks are marked as never
  /// written. `base` must outlive the result. Errors: kCorruption for a level that is too large for
  /// a file.
  std::vector<StoredLevel> levels(const BaseMesh& base) const;
  /// Throws unless version.S has the size that the manifest and the description say, and the
  /// checksum that the manifest records. Errors: kCorruption, kIo.
  void check_version_file() const;
  /// Reads the block tables of all stored levels from version.S, and checks that each entry is in
  /// its range. Tables of levels in shards are read later, when they are asked for. Errors:
  /// kCorruption, and then no level is changed; kIo.
  void read_tables_into(std::span<StoredLevel> levels) const;
  /// Reads and checks the block tables of one shard. Errors: kNotFound, kCorruption, kIo.
  void check_shard_tables(std::span<const StoredLevel> levels, std::uint32_t shard) const;
  /// The number of shards; 0 for levels in one piece.
  std::uint32_t shard_count() const {
    return static_cast<std::uint32_t>(description_.shards.size());
  }
  /// How the levels are cut; empty for levels in one piece. Takes memory for the edges, so the base
  /// mesh must have shown that there are that many.
  EdgeShards shards() const;
  /// The bytes that version.S would have with these tables.
  std::vector<std::byte> version_file_with(std::span<const BlockTable* const> tables) const;
  /// Reads the base records of an attribute in the description. Of `base`, it reads the positions
  /// if the records are packed and follow them. Errors: kNotFound, kCorruption, kIo.
  ZeroedArray<std::byte> read_base_records(const AttributeRecord& attribute,
                                           const BaseMesh& base) const;
  /// Throws unless the file with these records has its size and checksum. Errors: likewise.
  void check_base_file(const AttributeRecord& attribute) const;

  /// Reads the records of a face attribute in the description. Errors: as read_base_records().
  std::vector<std::byte> read_face_records(const FaceAttributeRecord& attribute) const;

  /// Reads the records of the change log; none if there is no log. Errors: kNotFound, kCorruption,
  /// kIo.
  const std::vector<ChangeRecord>& changes() const;
  bool has_log() const { return manifest_.log.generation != 0; }
  std::string log_name() const;

  std::string version_name() const;
  std::string face_records_name(const FaceAttributeRecord& attribute) const;
  std::string base_records_name(const AttributeRecord& attribute) const;
  /// The names of all files that this version needs, except the base mesh.
  std::set<std::string> file_names() const { return file_names(shard_count()); }
  /// The same for an older version, of which it is not known whether it is in shards: `shards` is
  /// the number of shards of the newest version, which all versions of a store have.
  std::set<std::string> file_names(std::uint32_t shards) const;
  /// Returns the open file version.S, with the reader's lock if it has one. No other function may
  /// be called after this.
  File release_file() && { return std::move(file_); }

 private:
  template <class Bytes>
  Bytes read_records(const std::string& name, std::uint64_t bytes, std::uint64_t checksum) const;
  void read_piece(const ChangedRecords& piece, std::span<std::byte> records) const;
  /// Enters the blocks of the change log in the tables of version.T.
  void enter_changes(std::span<const StoredLevel> levels, std::span<BlockTable> tables) const;
  ExpectedBase expected_base() const;

  const Directory& store_;
  Manifest manifest_;
  File file_;  ///< version.S
  std::vector<std::byte> description_bytes_;
  VersionDescription description_;
  bool is_newest_;
  mutable std::optional<std::vector<ChangeRecord>> changes_;
};

PLAIT_END_NAMESPACE
