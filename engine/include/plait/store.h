// plait/store.h: a semi-regular mesh in a directory. The base mesh is in memory. Each level of each
// attribute is a file, and its blocks are paged under one budget.
//
// Threads: while a thread calls a function that is not const, no other thread may call any function
// of the store. Several threads may call const functions, and use sessions, at the same time.
// Executors start threads of their own.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/backend.h"
#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/layout.h"
#include "plait/namespace.h"
#include "plait/options.h"
#include "plait/pager.h"
#include "plait/provenance.h"
#include "plait/rounding.h"

PLAIT_BEGIN_NAMESPACE

/// A position in Store::attributes(). Every call that takes one throws kInvalidArgument for a
/// number that is no attribute's.
using AttributeId = std::uint32_t;

/// An attribute of a store, and how far it is refined.
struct AttributeInfo {
  AttributeSchema schema;
  int finest_level = 0;  ///< levels base_level + 1 to finest_level have files
};

/// One block of a store.
struct BlockAddress {
  AttributeId attribute;
  int level;
  std::uint64_t block;
};

/// A semi-regular mesh and its attributes, in a directory or in memory. Move-only. The comment at
/// the head of plait/store.h says which calls exclude each other.
class Store {
 public:
  /// Makes a new store of `base`, whose edges and faces are in layout order. The store has no
  /// attribute yet. With an empty `path` the store is only in memory; then the backend must not be
  /// durable. The store can be opened after its first commit(). If `path` is a directory of a
  /// writer that was killed before its first commit, create() replaces the directory's content.
  /// Errors: kInvalidArgument, also if `path` exists otherwise; kNotSupported, kIo, kNoSpace.
  static Store create(const std::filesystem::path& path, BaseMesh base, const StoreOptions& options,
                      const BackendRegistry& backends);

  /// The same for the result of lay_out(). It also records the layout, so that a resumed
  /// subdivision can lay the mesh out in the same order.
  static Store create(const std::filesystem::path& path, LaidOutMesh mesh, StoreOptions options,
                      const BackendRegistry& backends);

  /// Opens the last committed version. One writer and any number of readers can have a store open
  /// at the same time. Errors: kNotFound; kCorruption; kNotSupported (format version, feature
  /// flags, backend); kBusy (the message names the process that has the store open).
  static Store open(const std::filesystem::path& path, const OpenOptions& options,
                    const BackendRegistry& backends);

  /// Returns false if the directory is empty, or if a writer was killed in it before its first
  /// commit. Returns true for any other directory, damaged or not. Errors: kIo.
  static bool has_commit(const std::filesystem::path& path);

  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  /// Discards all changes since the last commit. Never throws.
  ~Store();

  const std::filesystem::path& path() const;
  /// The mesh whose faces are patches and whose edges have slots: the user's mesh, refined
  /// base_level() times.
  const BaseMesh& base() const;
  /// The options of a created store, with the backend's default pipeline if the caller named none.
  /// For an opened store, the options that its version records.
  const StoreOptions& options() const;
  const StoreUuid& uuid() const;
  std::uint64_t sequence() const;  ///< commits so far
  BackendTraits backend_traits() const;

  /// How the levels were made. The next commit records it. subdivide() calls set_provenance().
  /// `layout` and `base_level` must be those of the store. Errors: kInvalidArgument, also for a
  /// name that is too long.
  const Provenance& provenance() const;
  void set_provenance(const Provenance& provenance);

  /// How often the user's mesh was refined to make base(): 0, unless slots of the finest level
  /// would be too large. Level numbers count from the user's mesh, in every call and message of a
  /// store. Level base_level() consists of the vertices of base(), which are in memory. The
  /// vertices of coarser levels are among them; these levels have no faces and edges with numbers
  /// of their own.
  int base_level() const;
  int finest_level() const;  ///< of the attribute with the most levels

  std::span<const AttributeInfo> attributes() const;
  /// Errors: kNotFound; the message lists the attributes of the store.
  AttributeId attribute(std::string_view name) const;
  bool has_attribute(std::string_view name) const;
  /// "RULE/SOURCE" if the attribute is computed when it is read, and has no files
  /// (plait/derivation.h); empty if it is stored.
  std::string_view derivation(AttributeId attribute) const;
  /// Errors: kInvalidArgument if the name is taken or ill-formed.
  AttributeId add_attribute(AttributeSchema schema);
  /// The same with all levels up to `finest_level`: every record is zero until it is written. After
  /// an error the store is as before. Errors: also kInvalidArgument for a level that a store cannot
  /// have; those of add_level().
  AttributeId add_attribute(AttributeSchema schema, int finest_level);
  /// Sets the pipelines (plait/level_pipelines.h) of levels that later calls of add_level() make;
  /// existing ones keep theirs (LevelFile::pipeline). The first value is options().pipeline.
  /// With "derived" or "derived:RULE/SOURCE", on every backend, the attribute is computed when it
  /// is read; it can have the levels that its source has (plait/derivation.h). Errors:
  /// kInvalidArgument or kNotSupported for a pipeline that the backend cannot use; kBadState for a
  /// change from or to a derived attribute that has levels.
  void set_pipeline(AttributeId attribute, std::string pipeline);
  /// Tells the store that levels up to `finest_level` will be added, and that they are what
  /// provenance() says. If the attribute's pipeline has the stage `predicted`, blocks that the
  /// scheme makes again are then stored in no bytes (plait/block_maker.h). Blocks with other
  /// content are stored as always. If nothing can make such levels, the pipeline loses the stage.
  /// `made_as`: the name under which subdivide() makes such an attribute, if it has another name
  /// for a while.
  void plan_levels(AttributeId attribute, int finest_level, std::string_view made_as = {});
  /// Adds one level to the attribute. Its blocks read as zeros until they are written.
  void add_level(AttributeId attribute);
  /// Removes the attribute with its levels. The attributes after it get smaller ids. Errors:
  /// kBadState for an attribute from which levels of another one were encoded, or from which
  /// another one is derived.
  void remove_attribute(AttributeId attribute);
  /// Removes `attribute` and gives its name to `replacement`. What was derived from `attribute` is
  /// derived from `replacement` now. Errors: as remove_attribute().
  void replace_attribute(AttributeId attribute, AttributeId replacement);

  /// How the records of the attribute's levels were rounded; nothing if they were not. The next
  /// commit records it. copy_attribute() sets it; a pass that gives the records other values sets
  /// it to nothing. Errors: kInvalidArgument for an error or a step that is negative or not finite.
  const std::optional<Rounding>& rounding(AttributeId attribute) const;
  void set_rounding(AttributeId attribute, const std::optional<Rounding>& rounding);

  /// The records of level base_level(): one for each base vertex, in memory. Those of a derived
  /// attribute cannot be changed; the first call, and the first one after a change of the source,
  /// computes them, which reads the source's finest level once.
  /// Errors: kInvalidArgument if the attribute has other records. Without const also kBadState for
  /// a store that was opened for reading, and for a derived attribute: read such records through a
  /// const Store. Derived ones: also those of Session::pin.
  template <class Record>
  std::span<Record> base_records(AttributeId attribute) {
    check_record_type<Record>();
    check_type(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    const std::span<std::byte> bytes = base_bytes(attribute);
    return {reinterpret_cast<Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  template <class Record>
  std::span<const Record> base_records(AttributeId attribute) const {
    check_record_type<Record>();
    check_type(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    const std::span<const std::byte> bytes = base_bytes(attribute);
    return {reinterpret_cast<const Record*>(bytes.data()), bytes.size() / sizeof(Record)};
  }
  std::span<std::byte> base_bytes(AttributeId attribute);
  std::span<const std::byte> base_bytes(AttributeId attribute) const;

  /// The open file of a level. Errors: kInvalidArgument unless base_level() < level <= finest level
  /// of the attribute.
  LevelFile& level_file(AttributeId attribute, int level);
  const LevelFile& level_file(AttributeId attribute, int level) const;
  /// Throws kInvalidArgument if the attribute has another type. The message names both types.
  void check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const;

  /// Opens a session for one reader, sweep or walk. Several sessions may be open at once, in
  /// several threads. A const store gives out only const levels, which can only be read. Errors:
  /// kOutOfMemory.
  Session open_session(const SessionOptions& options = {}) const;
  Pager& pager();
  const Pager& pager() const;

  /// Publishes all levels and attributes as the next version. Unless options().durability is kNone,
  /// the commit is durable: after a crash at any moment, open() gives either the version before or
  /// this version, complete. After a failed commit the store refuses further commits until it is
  /// opened again. REQUIRES: no block is pinned for writing. Errors: kIo, kNoSpace; kBadState after
  /// a failed write or commit. Also kBadState, without any change, while a level is unfinished: a
  /// pass that wrote to it was cancelled or failed, and no later pass has overwritten all of it;
  /// and for a derived attribute whose source does not have the same levels.
  void commit();
  /// Closes the store now, as the destructor does: discards all changes since the last commit, and
  /// releases the locks. Errors: kBusy with the number of readers and of their open views, if the
  /// store has readers (plait/reader.h). The destructor waits for nobody: after it, readers and
  /// views keep the store's files and memory, and the locks, until the last of them ends.
  void close();

  PagingStatistics statistics() const;
  /// Bytes of all levels and base records, and of the base mesh file: on disk, or in memory if the
  /// store has no path.
  std::uint64_t stored_bytes() const;

  struct Implementation;

 private:
  friend class Reader;
  explicit Store(std::unique_ptr<Implementation> implementation);
  std::shared_ptr<Implementation> implementation_;  ///< readers and views keep it alive
};

PLAIT_END_NAMESPACE
