// plait/patch_writer.h: fills levels of a store patch by patch, in any order of faces, from any
// number of threads: the inverse of Reader::read_patch().
//
//   store.add_attribute(schema_of<float>("height"), 5);
//   PatchWriter writer(store, {.attributes = {"height"}});
//   for (FaceId face = 0; face < store.base().face_count(); ++face)
//     writer.write_patch<float>("height", face, 5, heights_of(face));
//   writer.finish();
//   store.commit();
//
// Records are in row order (plait/reader.h). A vertex on an edge belongs to the two faces of the
// edge, and both patches have it. The writer takes the record of the *owner*: of a vertex on an
// edge, the own face of the edge; of a base vertex, the face of Topology::vertex_corners.
//
// The writer holds the blocks that it is filling: those of edges of which only one face was
// written. If the faces come in layout order (ascending or descending), these are few, and each
// block is written once and none is read. Of more blocks than its share of the budget has room for,
// some go to the disk, and come back when the next patch needs them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/session.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Options of a PatchWriter.
struct PatchWriterOptions {
  /// The attributes that the writer fills, by name. Empty: all attributes of the store.
  std::vector<std::string> attributes = {};
  /// The levels that the writer fills. Without a value: from Store::base_level() on, up to the
  /// finest level of each attribute. A program that computes level k + 1 from level k makes a
  /// writer for each level, and reads level k between two writers.
  std::optional<int> first_level = {}, last_level = {};
  /// Refuses a patch that gives a vertex another record than an earlier patch did. Records are
  /// equal if their bytes are.
  bool compare = false;
  /// The most bytes of blocks that the writer holds between two calls. 0: three quarters of the
  /// store's budget.
  std::uint64_t share_bytes = 0;
};

/// Every patch of the writer's levels must be written, by write_patch() or level by level by
/// write_level(); a patch may be written again. Until finish(), the levels are unfinished, base
/// records too if the writer fills them: nobody can read them, and commit() refuses the store and
/// names a face that nobody wrote. Threads:
/// by part: different faces or attributes (docs/threads.md); finish() and the destructor run alone.
/// A thread that writes must not hold pins of the same store.
class PatchWriter {
 public:
  /// Until finish(), the writer keeps the store's files and memory. Errors: kNotFound for an
  /// attribute that the store does not have; kInvalidArgument for levels that an attribute does not
  /// have; kNotSupported for a committed level whose blocks are encoded from other blocks (write to
  /// a new attribute, then call Store::replace_attribute()); kBadState for a store that was opened
  /// for reading, while a pass is under way, and for a level from which others are encoded; kBusy
  /// while the store has readers or views; kOutOfMemory.
  explicit PatchWriter(Store& store, const PatchWriterOptions& options = {});
  /// Without finish() the levels stay unfinished.
  ~PatchWriter();
  PatchWriter(PatchWriter&&) noexcept;
  PatchWriter& operator=(PatchWriter&&) = delete;

  /// Writes a patch at `level` with all coarser levels: the records of all
  /// patch_vertex_count(size) vertices of the grid. Levels that the writer does not fill are left
  /// out. Errors: kInvalidArgument for a face, a level or a number of records that does not fit,
  /// for another type of records, and, with PatchWriterOptions::compare, for a record that differs
  /// from that of another patch: the message names both faces, level, i, j and both records;
  /// kNotFound if the writer does not fill the attribute; kBudget if the blocks of one patch have
  /// no room; kBadState after finish(); those of Session::pin_many. After an error the patch counts
  /// as not written.
  template <class Record>
  void write_patch(std::string_view attribute, FaceId face, int level,
                   std::span<const Record> records) {
    check_record_type<Record>();
    write({attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents}, face,
          Levels::kUpTo, level, std::as_bytes(records));
  }
  /// The same for records of any type.
  void write_patch_of_bytes(std::string_view attribute, FaceId face, int level,
                            std::span<const std::byte> records) {
    write({attribute}, face, Levels::kUpTo, level, records);
  }

  /// Writes only the vertices that `level` creates. `records` is the whole grid of the patch, as
  /// for write_patch(); the records of coarser vertices are not read. At the base level these are
  /// the three corners. Errors: as write_patch().
  template <class Record>
  void write_level(std::string_view attribute, FaceId face, int level,
                   std::span<const Record> records) {
    check_record_type<Record>();
    write({attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents}, face,
          Levels::kOnly, level, std::as_bytes(records));
  }
  /// The same for records of any type.
  void write_level_of_bytes(std::string_view attribute, FaceId face, int level,
                            std::span<const std::byte> records) {
    write({attribute}, face, Levels::kOnly, level, records);
  }

  /// Ends the work: the levels can be read and committed. Other calls than statistics() then fail,
  /// a second finish() too. Errors: kBadState if a patch was not written: the message names
  /// attribute, level and face, and how many others are missing; the program may write them and
  /// call finish() again.
  void finish();

  PagingStatistics statistics() const;

 private:
  struct State;
  /// What a caller says about an attribute: components == 0 if it gives bytes.
  struct Target {
    std::string_view name;
    ComponentType type = ComponentType::kFloat32;
    std::uint32_t components = 0;
  };
  enum class Levels : std::uint8_t { kUpTo, kOnly };

  void write(const Target& target, FaceId face, Levels levels, int level,
             std::span<const std::byte> records);

  std::unique_ptr<State> state_;
};

PLAIT_END_NAMESPACE
