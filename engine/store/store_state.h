// What Store holds, shared by the files that implement it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plait/directory.h"
#include "plait/store.h"
#include "store/base_mesh_file.h"
#include "store/generation_volume.h"
#include "store/lock.h"
#include "store/manifest.h"
#include "store/rollback_journal.h"
#include "store/stored_version.h"

namespace plait {

struct Store::Implementation {
  struct Attribute {
    AttributeRecord record;  ///< its schema is in `infos`
    std::vector<std::byte> base_bytes;
    std::vector<std::unique_ptr<LevelFile>> levels;  ///< [level - base_level - 1]
  };

  Implementation() = default;
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  bool on_disk() const { return !path.empty(); }
  /// Opens a level's backend; `level` comes from a committed version, or is new.
  std::unique_ptr<LevelFile> open_level(StoredLevel level, const AttributeSchema& schema,
                                        OpenMode mode) const;
  /// The pager, and a journal where one is needed; `options`, `backend` and the rest are there.
  void make_ready();
  /// Of what there is now; the checksums of base records are not in it yet.
  VersionDescription description() const;
  void write_version();
  /// The generation that the version on its way has of levels with a new file.
  void enter_renewed_levels();
  void read_version(const StoredVersion& version, OpenMode mode);
  /// Reads block tables of `versions_read`, so that the blocks of these versions stay.
  void hold_versions();
  bool overwrites_in_place() const {
    return on_disk() && writable && backend.traits.overwrites_in_place &&
           options.overwriting == Overwriting::kInPlace;
  }

  std::filesystem::path path;  ///< as the user gave it
  Directory directory;         ///< by which all in it is reached; not open without a path
  BaseMesh base;
  StoreOptions options;
  Provenance provenance;
  BackendRegistry::Entry backend;
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint32_t next_number = 0;  ///< of the next attribute
  StoredSize base_mesh_size;
  bool writable = false;
  bool name_is_durable = false;  ///< this writer has synced the directory that the store is in
  bool failed = false;           ///< a commit did: what is on the disk is not known
  StoreLock lock;                ///< a writer's
  File
      version_file;  ///< locked: a reader's version, or the one that a writer in place keeps closed
  std::unique_ptr<RollbackJournal> journal;  ///< of a durable writer that writes in place
  std::unique_ptr<Volume> volume;
  GenerationVolume* generations = nullptr;   ///< `volume`, for a writer that makes new files
  std::vector<std::uint64_t> versions_read;  ///< older ones that readers may have open, ascending
  struct HeldVersion {
    std::uint64_t version;
    std::vector<StoredLevel> levels;
  };
  std::vector<HeldVersion> held;  ///< only while a version is read
  std::vector<AttributeInfo> infos;
  std::vector<Attribute> attributes;
  std::unique_ptr<Pager> pager;  ///< last: it refers to the level files
};

}  // namespace plait
