// The state of a Store. All source files of Store share it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/directory.h"
#include "plait/store.h"
#include "store/base_mesh_file.h"
#include "store/derived_attribute.h"
#include "store/generation_volume.h"
#include "store/lock.h"
#include "store/manifest.h"
#include "store/rollback_journal.h"
#include "store/stored_version.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct Store::Implementation {
  struct Attribute {
    AttributeRecord record;  ///< its schema is in `infos`
    std::vector<std::byte> base_bytes;
    std::vector<std::unique_ptr<LevelFile>> levels;  ///< [level - base_level - 1]
    std::unique_ptr<DerivedAttribute> derived;       ///< of a derived attribute; it has no files
  };

  Implementation() = default;
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  bool on_disk() const { return !path.empty(); }
  /// Opens the backend of a level. `level` comes from a committed version, or is new.
  std::unique_ptr<LevelFile> open_level(StoredLevel level, const AttributeSchema& schema,
                                        OpenMode mode) const;
  // derived_levels.cpp
  /// The pipeline as the store records it: a derived one names its rule and source. Errors: those
  /// of the backend's validate_pipeline() and of Derivations.
  std::string checked_pipeline(std::string pipeline, const AttributeSchema& schema) const;
  /// Makes `derived` of an attribute, or removes it, as the record's pipeline says.
  void follow_pipeline(Attribute& attribute, const AttributeSchema& schema) const;
  /// Opens level `level` of a derived attribute, whose source has the level `finest` at last.
  std::unique_ptr<LevelFile> open_derived_level(const Attribute& attribute,
                                                const AttributeSchema& schema, int level,
                                                int finest) const;
  /// Errors: kBadState unless the source has this level.
  void add_derived_level(AttributeId attribute);
  /// Connects derived attributes with their sources. To be called after each change of attributes
  /// or levels.
  void connect_derived();
  /// The position of the attribute's source; kNoId if there is none.
  AttributeId source_of(const Attribute& derived) const;
  /// Derived records that depend on this attribute are outdated.
  void base_changed(AttributeId attribute);

  /// The base mesh and the levels that are open.
  LevelSurroundings surroundings() const;
  /// Fixes the levels that the written blocks of `level` were encoded from.
  void fix_context_of(const LevelFile& level) const;
  /// Opens the volume and makes the pager. REQUIRES: the other members are set.
  void make_ready();
  /// Opens the volume, with generations or the journal around it. `threads` call it at once.
  void open_volume(int threads);
  /// The description of the current state, without the checksums of base records.
  VersionDescription description() const;
  void write_version();
  /// Sets the generation of the levels that get a new file in the next version.
  void enter_renewed_levels();
  void read_version(const StoredVersion& version, OpenMode mode);
  /// Reads the block tables of `versions_read`, so that the backend does not overwrite blocks of
  /// these versions.
  void hold_versions();
  bool overwrites_in_place() const {
    return on_disk() && writable && backend.traits.overwrites_in_place &&
           options.overwriting == Overwriting::kInPlace;
  }

  std::filesystem::path path;  ///< as the user gave it
  Directory directory;         ///< all files are opened through it; not open without a path
  BaseMesh base;
  StoreOptions options;
  Provenance provenance;
  BackendRegistry::Entry backend;
  std::shared_ptr<const Derivations> derivations;
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint32_t next_number = 0;  ///< of the next attribute
  StoredSize base_mesh_size;
  bool writable = false;
  bool name_is_durable = false;  ///< this writer has synced the directory that the store is in
  bool failed = false;  ///< a commit has failed: the newest version on the disk is not known
  StoreLock lock;       ///< only for a writer
  File version_file;    ///< locked: the version of a reader, or the version that a writer in place
                        ///< locks against readers
  std::unique_ptr<RollbackJournal> journal;  ///< only for a durable writer that writes in place
  std::unique_ptr<Volume> volume;
  GenerationVolume* generations = nullptr;  ///< `volume`, if the writer makes new level files
  std::vector<std::uint64_t>
      versions_read;  ///< older versions that readers may have open, ascending
  struct HeldVersion {
    std::uint64_t version;
    std::vector<StoredLevel> levels;
  };
  std::vector<HeldVersion> held;  ///< only while read_version() runs
  std::vector<AttributeInfo> infos;
  std::vector<Attribute> attributes;
  mutable std::atomic<std::uint64_t> view_count = 0;  ///< PatchViews that have not ended
  std::unique_ptr<Pager> pager;  ///< last, because it refers to the level files
};

PLAIT_END_NAMESPACE
