// plait/store.h: a semi-regular mesh in a directory. The base mesh is in memory. Each level of each
// attribute is a file, and its blocks are paged under one budget.
//
// Threads: const shared (docs/threads.md). Sessions and readers count as const calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "plait/attribute.h"
#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/provenance.h"
#include "plait/layout.h"
#include "plait/options.h"
#include "plait/progress.h"

PLAIT_BEGIN_NAMESPACE

class BackendRegistry;
class StoreNotes;
struct StoreInfo;

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

/// A semi-regular mesh and its attributes, in a directory or in memory. Move-only. Threads:
/// const shared (docs/threads.md).
class Store {
 public:
  /// Makes a new store of `mesh`. The store has no attribute yet. With an empty `path` the store is
  /// only in memory; then, and only then, the backend is one that writes no files. The store can be
  /// opened after its first commit(). If `path` is a directory of a writer that was killed before
  /// its first commit, create() replaces the directory's content. `provenance` says how often the
  /// user's mesh was refined to make this one: {.base_level = 2}. The store's layout is that of
  /// `mesh`, or, if `mesh` is in no layout but its own, that of `provenance`. create_store()
  /// (plait/create_store.h) does it with the built-in backends. Errors: kInvalidArgument, also if
  /// `path` exists otherwise; kNotSupported, kIo, kNoSpace.
  static Store create(const std::filesystem::path& path, LaidOutMesh mesh,
                      const StoreOptions& options, const BackendRegistry& backends,
                      const Provenance& provenance = {});

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
  std::uint64_t sequence() const;  ///< commits so far
  /// Figures of the store as it is now (plait/store_info.h). Errors: kOutOfMemory.
  StoreInfo info() const;

  /// How the levels were made: subdivide() tells it, and the next commit records it.
  const Provenance& provenance() const;

  /// How often the user's mesh was refined to make base(): 0, unless slots of the finest level
  /// would be too large. Level numbers count from the user's mesh, in every call and message of a
  /// store. Level base_level() consists of the vertices of base(), which are in memory. The
  /// vertices of coarser levels are among them; these levels have no faces and edges with numbers
  /// of their own.
  int base_level() const;
  int finest_level() const;  ///< of the attribute with the most levels

  /// Whether faces have depths of their own (docs/adaptive.md): plait prune makes such stores.
  bool has_depths() const;
  /// The finest level that a face of base() has: finest_level(), unless the store has depths.
  /// Errors: kInvalidArgument for a face that is not there.
  int depth(FaceId face) const;

  std::span<const AttributeInfo> attributes() const;
  /// Errors: kNotFound; the message lists the attributes of the store.
  AttributeId attribute(std::string_view name) const;
  bool has_attribute(std::string_view name) const;
  /// Errors: kInvalidArgument if the name is taken or ill-formed.
  AttributeId add_attribute(AttributeSchema schema);
  /// The same with all levels up to `finest_level`: every record is zero until it is written. After
  /// an error the store is as before. Errors: also kInvalidArgument for a level that a store cannot
  /// have; those of add_level().
  AttributeId add_attribute(AttributeSchema schema, int finest_level);
  /// Sets the pipelines (plait/extend/pipeline.h) that levels have in the end which later calls of
  /// add_level() make; existing ones keep theirs. The first value is that of options(). Errors:
  /// kInvalidArgument or kNotSupported for a pipeline that the backend cannot use.
  void set_pipeline(AttributeId attribute, LevelPipelines pipeline);
  /// Adds one level to the attribute. Its blocks read as zeros until they are written, by any
  /// passes: if the level's pipeline encodes blocks from other blocks, the level has another
  /// pipeline (LevelFile::pipeline) until finish_encoding().
  void add_level(AttributeId attribute);
  /// Encodes levels that do not have their own pipeline yet, attribute by attribute, as
  /// recode_attribute() does: such an attribute gets new files, and another LevelFile for each
  /// level. commit() calls it; a program calls it to show the progress, which counts raw bytes, or
  /// to cancel. After an error each attribute is encoded either way, and another call goes on.
  /// Errors: kCancelled; kBadState for unfinished levels, while a pass is under way, in the pause
  /// of a longer work and during a walk; kBusy while the store has readers; those of reading and
  /// writing blocks.
  void finish_encoding(const ProgressCallback& progress = {});
  /// Removes the attribute with its levels. The attributes after it get smaller ids. Errors:
  /// kBadState for an attribute from which levels of another one were encoded.
  void remove_attribute(AttributeId attribute);
  /// Removes `attribute` and gives its name to `replacement`. Errors: as remove_attribute();
  /// kInvalidArgument if `attribute` is a scheme's "position" and the types differ.
  void replace_attribute(AttributeId attribute, AttributeId replacement);

  /// Attributes of base faces, and texts (plait/notes.h). Valid while the store is open.
  StoreNotes& notes();
  const StoreNotes& notes() const;

  /// The records of level base_level(): one for each base vertex, in memory. Errors:
  /// kInvalidArgument if the attribute has other records; kBadState if they are unfinished: a pass
  /// that wrote them was cancelled or failed. Without const also kBadState for a store that was
  /// opened for reading, and if blocks were encoded from these records: read them through a const
  /// Store.
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

  /// Publishes all levels, attributes and texts as the next version, if anything has changed since
  /// the last one, after finish_encoding(). Unless options().durability is kNone, the commit is
  /// durable: after a crash at any moment, open() gives either the version before or this version,
  /// complete. After a failed commit the store refuses further commits until it is opened again.
  /// REQUIRES: no block is pinned for writing. Errors: kIo, kNoSpace; kBadState after a failed
  /// write or commit. Also kBadState, without any change, while a pass is under way, or a level or
  /// base records are unfinished: a pass that wrote to them was cancelled or failed, and no later
  /// pass has overwritten all of them. Nobody can read such records: run the pass again, or
  /// roll_back(). kBusy while the store has readers or views.
  void commit();
  /// Brings the store back to its last commit, or, before the first one, to a store without
  /// attributes and texts: discards all changes, and what cancelled and failed passes left.
  /// Attributes have the numbers that they had then. A store in memory keeps the old bytes of
  /// blocks that change after a commit, until the next one. Errors: kBadState for a store that was
  /// opened for reading, while a pass is under way, and after a failed commit; kBusy while the
  /// store has readers or views; those of open().
  void roll_back();
  /// Closes the store now, as the destructor does: discards all changes since the last commit, and
  /// releases the locks. Then every call but close() fails with kBadState, as for a store that was
  /// moved from. Errors: kBusy with the number of readers and of their open views, if the store has
  /// some (plait/reader.h); kBadState while a pass is under way. The destructor waits for nobody:
  /// after it, readers and views keep the store's files and memory, and the locks, until the last
  /// of them ends.
  void close();

  struct Implementation;

 private:
  friend class Reader;
  friend class StoreAccess;  // plait/extend/store_access.h describes these
  friend class StorePass;
  /// Every function of the store takes its state from here. Errors: kBadState for a store that is
  /// closed or moved from, and in a process that was forked from the store's.
  Implementation& state() const;
  void add_level(AttributeId attribute, bool is_final);
  void check_type(AttributeId attribute, ComponentType type, std::uint32_t components) const;

  explicit Store(std::unique_ptr<Implementation> implementation);
  std::shared_ptr<Implementation> implementation_;  ///< readers and views keep it alive
};

/// Adds the attribute "position" to a store that has no attribute yet, with three components of
/// type `precision`, and fills its base records from base().positions(). Errors: kInvalidArgument
/// unless `precision` is float32 or float64, and for a position that is too large for float32.
void add_base_positions(Store& store, ComponentType precision = ComponentType::kFloat32);

PLAIT_END_NAMESPACE
