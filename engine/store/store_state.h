// What Store holds, shared by the files that implement it.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plait/directory.h"
#include "plait/store.h"
#include "store/base_mesh_file.h"
#include "store/lock.h"
#include "store/manifest.h"
#include "store/rollback_journal.h"

namespace plait {

struct Store::Implementation {
  struct Attribute {
    std::uint32_t number = 0;  ///< in file names and checksums; never given twice
    std::vector<std::byte> base_bytes;
    std::vector<std::unique_ptr<LevelFile>> levels;  ///< [level - base_level - 1]
  };

  Implementation() = default;
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  bool on_disk() const { return !path.empty(); }
  /// What is written goes where committed blocks lie.
  bool writes_in_place() const { return backend.traits.durable && !backend.traits.compressed; }
  /// Opens a level's backend; `entries` come from a committed version, empty for a new level.
  std::unique_ptr<LevelFile> open_level(const Attribute& attribute, const AttributeSchema& schema,
                                        int level, OpenMode mode,
                                        std::span<const BlockEntry> entries) const;
  /// The pager, and a journal where one is needed; `options`, `backend` and the rest are there.
  void make_ready();
  Manifest manifest() const;
  void write_version();
  void read_version(const Manifest& manifest, OpenMode mode);

  std::filesystem::path path;  ///< as the user gave it
  Directory directory;         ///< by which all in it is reached; not open without a path
  BaseMesh base;
  StoreOptions options;
  BackendRegistry::Entry backend;
  StoreUuid uuid{};
  std::uint64_t sequence = 0;
  std::uint32_t next_number = 0;
  StoredSize base_mesh_size;
  bool writable = false;
  bool name_is_durable = false;  ///< this writer has synced the directory that the store is in
  bool failed = false;           ///< a commit did: what is on the disk is not known
  StoreLock lock;
  std::unique_ptr<RollbackJournal> journal;  ///< of a durable writer that writes in place
  std::vector<AttributeInfo> infos;
  std::vector<Attribute> attributes;
  std::vector<std::string> obsolete;  ///< names of files to remove after the next commit
  std::unique_ptr<Pager> pager;       ///< last: it refers to the level files
};

/// Serialised block tables of all levels (docs/format.md, "tables.S").
std::vector<std::byte> encode_tables(const Store::Implementation& store);

}  // namespace plait
