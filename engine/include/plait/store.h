// plait/store.h: a semi-regular mesh in a directory: base mesh in memory, one file per level and
// attribute, paged under one budget.
//
// Threads: while a thread calls a non-const function, no other thread calls any; const functions
// and sessions may be called from several threads. Executors use threads of their own.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/backend.h"
#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "plait/pager.h"
#include "plait/provenance.h"

namespace plait {

using AttributeId = std::uint32_t;  ///< position in Store::attributes()

struct AttributeInfo {
  AttributeSchema schema;
  int finest_level = 0;  ///< levels base_level+1 .. finest_level have files
};

struct BlockAddress {
  AttributeId attribute;
  int level;
  std::uint64_t block;
};

class Store {
 public:
  /// A new store of `base` in layout order, with no attribute yet. With an empty `path` nothing
  /// touches the disk; the backend must then not be durable. The directory is complete and
  /// openable from the first commit() on; what a writer left that was killed before it is replaced.
  /// Errors: kInvalidArgument, kNotSupported, kIo, kNoSpace;
  /// kInvalidArgument if `path` exists.
  static Store create(const std::filesystem::path& path, BaseMesh base, const StoreOptions& options,
                      const BackendRegistry& backends);

  /// The same of a mesh that was laid out, and records which layout it has: a subdivision that is
  /// resumed lays the mesh out again.
  static Store create(const std::filesystem::path& path, LaidOutMesh mesh, StoreOptions options,
                      const BackendRegistry& backends);

  /// The last committed version. One writer, and any number of readers beside it.
  /// Errors: kNotFound, kCorruption, kNotSupported (version, feature flags, backend), kBusy naming
  /// the holder.
  static Store open(const std::filesystem::path& path, const OpenOptions& options,
                    const BackendRegistry& backends);

  /// False where the directory is empty, or a writer was killed in it before its first commit; true
  /// of anything else, damaged or not. Errors: kIo.
  static bool has_commit(const std::filesystem::path& path);

  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  /// Loses what was not committed. Never throws.
  ~Store();

  const std::filesystem::path& path() const;
  /// The mesh whose faces are patches and whose edges have slots: the one that the user gave,
  /// refined base_level() times.
  const BaseMesh& base() const;
  /// As created, with the backend's default pipeline where none was named; of an opened store, as
  /// its version says.
  const StoreOptions& options() const;
  const StoreUuid& uuid() const;
  std::uint64_t sequence() const;  ///< commits so far
  BackendTraits backend_traits() const;

  /// Where the levels come from. set_provenance says it, for the next commit to record, as
  /// subdivide() does by itself; `layout` and `base_level` must be those that the store has.
  /// Errors: kInvalidArgument, also for a name that is too long.
  const Provenance& provenance() const;
  void set_provenance(const Provenance& provenance);

  /// Level numbers, in every call and message of a store, count from the mesh that the user gave.
  /// base() is that mesh refined base_level() times: 0 unless slots of the finest level would be
  /// larger than they may be. Level base_level() are the vertices of base(), in memory with it;
  /// levels before it are among these and have no number for face and edge of their own.
  int base_level() const;
  int finest_level() const;  ///< of the attribute with most levels

  std::span<const AttributeInfo> attributes() const;
  /// Errors: kNotFound naming the attributes there are.
  AttributeId attribute(std::string_view name) const;
  bool has_attribute(std::string_view name) const;
  /// Errors: kInvalidArgument if the name is taken or ill-formed.
  AttributeId add_attribute(AttributeSchema schema);
  /// How blocks of levels that add_level() makes from now on are encoded; those that are there keep
  /// what they have (LevelFile::pipeline). At first it is options().pipeline.
  /// Errors: kInvalidArgument, kNotSupported for a pipeline that the backend does not have.
  void set_pipeline(AttributeId attribute, std::string pipeline);
  /// One level more for this attribute; reads as zeros until written.
  void add_level(AttributeId attribute);
  /// Removes `attribute` and calls `replacement` by its name.
  void replace_attribute(AttributeId attribute, AttributeId replacement);

  /// Level base_level(): one record per base vertex, in memory.
  template <class Record>
  std::span<Record> base_records(AttributeId attribute) {
    check_type(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    const std::span<std::byte> bytes = base_bytes(attribute);
    return {reinterpret_cast<Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  template <class Record>
  std::span<const Record> base_records(AttributeId attribute) const {
    check_type(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    const std::span<const std::byte> bytes = base_bytes(attribute);
    return {reinterpret_cast<const Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  std::span<std::byte> base_bytes(AttributeId attribute);
  std::span<const std::byte> base_bytes(AttributeId attribute) const;

  /// The open file of a level. REQUIRES: base_level() < level <= finest level of the attribute.
  LevelFile& level_file(AttributeId attribute, int level);
  const LevelFile& level_file(AttributeId attribute, int level) const;
  /// Errors: kInvalidArgument naming both types.
  void check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const;

  /// For one reader, sweep or walk: several may be open at once, in several threads. What a const
  /// store gives out can only be read. Errors: kOutOfMemory.
  Session open_session(const SessionOptions& options = {}) const;
  Pager& pager();
  const Pager& pager() const;

  /// Publishes all levels and attributes as the next version, durably unless options().durability
  /// is kNone: after a crash at any moment open() gives the version before, or this one, whole.
  /// After an error nothing more can be committed before the store is opened again. REQUIRES: no
  /// block is pinned for writing. Errors: kIo, kNoSpace; kBadState after a failed write or commit,
  /// and, with nothing changed, while a level is unfinished: a pass that writes to it was cancelled
  /// or failed, and no other has overwritten all of it since.
  void commit();
  /// As the destructor, now: what was not committed is lost, and others may open the store.
  void close();

  PagingStatistics statistics() const;
  /// Everything the store takes on disk, or in memory for one without a path.
  std::uint64_t stored_bytes() const;

  struct Implementation;

 private:
  explicit Store(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plait
