// The state of a Store. All source files of Store share it.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/contention.h"
#include "base/stopwatch.h"
#include "blocks/telling_volume.h"
#include "format/base_mesh_file.h"
#include "format/manifest.h"
#include "io/process.h"
#include "plait/detail/edge_shards.h"
#include "plait/extend/backend_registry.h"
#include "plait/extend/directory.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "plait/store.h"
#include "store/base_records.h"
#include "store/lock.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GenerationVolume;
struct MemorySnapshot;

struct Store::Implementation {
  /// Who may have changed records in memory since the last commit.
  struct Changes {
    bool may_have_some = true;  ///< a pass had them to write, or they are new
    bool are_lent = false;      ///< a program has their address, and writes to them when it likes
    bool must_be_looked_for() const { return may_have_some || are_lent; }
  };

  struct Attribute {
    AttributeRecord record;  ///< its schema is in `infos`
    BaseRecords base_bytes;
    Changes base_changes = {};
    /// Of `base_bytes`: at the last commit, and when find_changed_records() looked.
    std::vector<std::uint64_t> piece_checksums = {}, piece_checksums_now = {};
    /// Whether `base_bytes` are finished. Stays where it is: passes keep its address.
    std::unique_ptr<WrittenRecords> base_written = std::make_unique<WrittenRecords>();
    /// Only a replacement: the name that it gets in the end. Until then it has one that no program
    /// can give.
    std::string becomes = {};
    std::vector<std::unique_ptr<LevelFile>> levels;  ///< [level - base_level - 1]
    /// `record.pipeline` before plan_levels() wrote recipes into it.
    std::optional<LevelPipelines> unplanned = {};
    /// [level] what levels get that do not have their own pipeline yet.
    std::map<int, Pipeline> last_pipelines = {};

    const LevelPipelines& named_pipelines() const {
      return unplanned ? *unplanned : record.pipeline;
    }
  };

  struct FaceAttribute {
    std::uint32_t number = 0;
    std::uint64_t checksum = 0;  ///< of the bytes at the last commit
    std::vector<std::byte> bytes;
    Changes changes = {};
    std::uint64_t checksum_now = checksum;  ///< when find_changed_records() looked
  };

  Implementation() = default;
  ~Implementation();
  /// The owner of a state. In a process that was forked it only frees memory: it ends no threads
  /// and removes no files, which are those of the other process.
  static std::shared_ptr<Implementation> own(std::unique_ptr<Implementation> state);
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  bool is_part() const { return only_shard != kNoId; }
  /// Opens the version, whose levels are not written to unless `wanted` says so.
  void open_version(const StoredVersion& version, const OpenOptions& wanted,
                    const BackendRegistry& backends);
  /// Where the slots and blocks of a level are, before it is known which shards are here.
  LevelGeometry whole_geometry(std::size_t record_bytes, int level,
                               std::uint64_t block_bytes) const;
  bool on_disk() const { return !path.empty(); }
  /// For messages: the path, or "a store in memory".
  const std::string& name() const;
  /// The attribute's schema, for a replacement with the name that it gets in the end.
  AttributeSchema final_schema(AttributeId attribute) const;
  /// Opens the backend of a level. `level` comes from a committed version, or is new.
  std::unique_ptr<LevelFile> open_level(StoredLevel level, const AttributeSchema& schema,
                                        OpenMode mode) const;

  /// The base mesh and the levels that are open.
  LevelSurroundings surroundings() const;
  /// Fixes the levels that the written blocks of `level` were encoded from.
  void fix_context_of(const LevelFile& level) const;
  /// Opens the volume and makes the pager. REQUIRES: the other members are set.
  void make_ready();
  /// Opens the volume, with generations around it if the backend overwrites in place. `threads`
  /// call it at once.
  void open_volume(int threads);
  /// The description of the current state, without the checksums of base records.
  VersionDescription description() const;
  /// Writes a version with files of its own, or a record of changes.
  void write_version();
  /// Writes the next version to the change log, if nothing but blocks that are there, and base
  /// records, has changed. Returns whether that is so. REQUIRES: all levels were synced.
  bool write_changes(bool durable);
  void write_whole_version(bool durable);
  /// Base records of a new attribute, in the file that they have in the next version.
  BaseRecords base_records_in_file(std::uint32_t attribute, std::uint64_t bytes) const;
  /// Notes what locks do not protect this writer from.
  void note_missing_locks();
  /// Tells options.events how long it took.
  void tell(StoreEvent::Kind kind, const Stopwatch& watch) const noexcept;
  /// Computes checksums of base records and face records that may have changed.
  void find_changed_records();
  /// Whether anything differs from the last commit. REQUIRES: the pager has written all blocks, and
  /// find_changed_records() has looked.
  bool has_changes() const;
  /// REQUIRES: find_changed_records() has looked.
  void note_committed();
  /// Takes levels out of the store. What the last commit of a store in memory has of them is kept.
  void retire(std::vector<std::unique_ptr<LevelFile>> levels);
  /// Reads the newest version again, in the place of all that the store has.
  void reread();
  /// The level's whole file.
  std::filesystem::path path_of(const LevelFile& level) const;
  void read_version(const StoredVersion& version, OpenMode mode);
  /// Reads the block tables of `versions_read`, so that the backend does not overwrite blocks of
  /// these versions.
  void hold_versions();

  std::filesystem::path path;  ///< as the user gave it
  Directory directory;         ///< all files are opened through it; not open without a path
  BaseMesh base;
  bool in_shards = false;     ///< an opened store whose levels are in shards
  EdgeShards shards;          ///< of all levels; empty: each level is in one piece
  bool shares_files = false;  ///< as in VersionDescription
  /// Only the store of one part (store/parts/part_store.h): the only shard that it makes.
  std::uint32_t only_shard = kNoId;
  /// Only the store of a part of a pass: the directory of the levels that it makes.
  Directory made_in;
  StoreAccess::BlockFilled block_filled = {};
  std::uint32_t first_made = 0;  ///< the number of the first attribute that the part makes
  StoreOptions options;
  Provenance provenance, first_provenance;  ///< now, and of the store when it was made
  RegisteredBackend backend;
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  Manifest committed = {};                  ///< of the version on the disk
  GenerationVolume* generations = nullptr;  ///< `volume`, if it is one
  std::uint32_t next_number = 0;            ///< of the next attribute
  StoredSize base_mesh_size;
  std::uint64_t depths_checksum = 0;  ///< of the file, if base.depths()
  bool has_base_index = false;        ///< the directory has the file base.index
  bool writable = false;
  bool name_is_durable = false;  ///< this writer has synced the directory that the store is in
  bool changed = false;          ///< something beside records has changed since the last commit
  std::uint64_t blocks_at_commit = 0;  ///< that the pager had written then
  bool failed = false;  ///< a commit has failed: the newest version on the disk is not known
  StoreLock lock;       ///< only for a writer
  File version_file;    ///< only for a reader: its version, locked
  std::unique_ptr<Volume> volume;
  std::vector<std::uint64_t>
      versions_read;  ///< older versions that readers may have open, ascending
  struct HeldVersion {
    std::uint64_t version;
    std::vector<StoredLevel> levels;
  };
  std::vector<HeldVersion> held;           ///< only while read_version() runs
  std::vector<std::string> notices;        ///< of the store itself (plait/extend/notices.h)
  const TellingVolume* telling = nullptr;  ///< the backend's volume, if it is one
  std::vector<AttributeInfo> infos;
  std::vector<Attribute> attributes;
  std::vector<AttributeSchema> face_infos;
  std::vector<FaceAttribute> face_attributes;
  Texts texts;
  StoreNotes notes{*this};  ///< the door to face attributes and texts
  /// The last commit of a store in memory; not set before the first one.
  std::shared_ptr<MemorySnapshot> snapshot;
  const OwnProcess process;
  /// Readers and PatchViews that have not ended.
  mutable std::atomic<std::uint64_t> reader_count = 0;
  mutable SplitCounter view_count;
  /// Counted by StorePass, for each kind.
  mutable std::array<std::atomic<std::uint32_t>, 3> pass_counts{};
  std::unique_ptr<Pager> pager;  ///< last, because it refers to the level files
};

PLAIT_END_NAMESPACE
