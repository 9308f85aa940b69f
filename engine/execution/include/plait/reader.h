// plait/reader.h: reads single patches of a store, in any order, from any number of threads.
//
//   Reader reader(store);
//   PatchView patch = reader.read_patch(face, 5);
//   AttributeView position = patch.attribute<Vector3<float>>("position");
//   position.at(i, j);
//
// A patch at a level is a triangular grid of (size + 1)(size + 2) / 2 vertices, where `size` is the
// number of steps along a side. Its corners are (0, 0), (size, 0) and (0, size). Vertices in *row
// order* are (0, 0), (1, 0), ..., (size, 0), (0, 1), (1, 1), ..., (size - 1, 1), ..., (0, size).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plait/bounds.h"
#include "plait/detail/face_slots.h"
#include "plait/detail/namespace.h"
#include "plait/extend/session.h"
#include "plait/progress.h"
#include "plait/store.h"

PLAIT_BEGIN_NAMESPACE

/// Options of a Reader.
struct ReaderOptions {
  /// The attributes that the reader reads, by name. Empty: all attributes of the store.
  std::vector<std::string> attributes = {};
  /// kClock suits patches in random order, kLayoutOrder suits faces that ascend.
  EvictionPolicy policy = EvictionPolicy::kClock;
  /// The part of the store's budget that the reader counts on (SessionOptions::share_bytes).
  std::uint64_t share_bytes = 0;
};

/// The number of vertices of a patch whose sides have `size` steps.
constexpr std::uint64_t patch_vertex_count(std::int64_t size) noexcept {
  return static_cast<std::uint64_t>((size + 1) * (size + 2) / 2);
}
/// The place of (i, j) in row order.
constexpr std::int64_t patch_vertex(std::int64_t size, std::int64_t i, std::int64_t j) noexcept {
  return j * (size + 1) - j * (j - 1) / 2 + i;
}

/// Throws kInvalidArgument: (i, j) is no point of the patch.
[[noreturn]] void refuse_point(FaceId face, std::int64_t size, std::int64_t i, std::int64_t j);
/// Throws kInvalidArgument unless `count` is patch_vertex_count(size).
void check_count(FaceId face, std::int64_t size, std::size_t count);

/// One attribute of a PatchView, which must outlive it. Of a PatchView that is a temporary object,
/// it keeps the pins: `auto position = reader.read_patch(face, 5).attribute<P>("position")`.
/// Threads: shared (docs/threads.md).
template <class Record>
class AttributeView {
 public:
  std::int64_t size() const noexcept { return size_; }
  /// The record at a point of the patch's grid.
  /// Errors: kInvalidArgument for a point outside the patch.
  [[gnu::always_inline]] const Record& at(std::int64_t i, std::int64_t j) const {
    if ((i | j | (size_ - i - j)) < 0) [[unlikely]]
      refuse_point(face_, size_, i, j);
    return *reinterpret_cast<const Record*>(slots_->find(refinements_, i, j));
  }
  /// Copies all records to `to` in row order. Errors: kInvalidArgument unless `to` has
  /// patch_vertex_count(size()) records.
  void copy_to(std::span<Record> to) const {
    check_count(face_, size_, to.size());
    slots_->copy_to(refinements_, to.data());
  }

 private:
  friend class PatchView;
  AttributeView(const FaceSlots& slots, FaceId face, int refinements)
      : slots_(&slots),
        size_(std::int64_t{1} << refinements),
        refinements_(refinements),
        face_(face) {}

  const FaceSlots* slots_;
  std::int64_t size_;
  int refinements_;
  FaceId face_;
  std::shared_ptr<const void> pins_;  ///< of a PatchView that was a temporary object
};

/// One attribute of a PatchView as bytes, for a program that learns the type of the records only
/// while it runs. As with AttributeView, the PatchView must outlive it unless it is a temporary
/// object. Threads: shared (docs/threads.md).
class RecordView {
 public:
  std::int64_t size() const noexcept { return size_; }
  std::size_t record_bytes() const noexcept { return record_bytes_; }
  /// The bytes of the record at a point of the patch's grid.
  /// Errors: kInvalidArgument for a point outside the patch.
  std::span<const std::byte> at(std::int64_t i, std::int64_t j) const;
  /// Copies all records to `to` in row order. Errors: kInvalidArgument unless `to` has
  /// patch_vertex_count(size()) times record_bytes() bytes.
  void copy_to(std::span<std::byte> to) const;

 private:
  friend class PatchView;
  RecordView(const FaceSlots& slots, FaceId face, int refinements, std::size_t record_bytes)
      : slots_(&slots),
        size_(std::int64_t{1} << refinements),
        record_bytes_(record_bytes),
        refinements_(refinements),
        face_(face) {}

  const FaceSlots* slots_;
  std::int64_t size_;
  std::size_t record_bytes_;
  int refinements_;
  FaceId face_;
  std::shared_ptr<const void> pins_;  ///< as in AttributeView
};

class Reader;

/// The records of one patch, at their addresses in memory. A view pins its blocks until it ends,
/// so a program that keeps many views uses up the budget. A view may outlive its reader and its
/// store: the files and the memory of the store stay until the last view has ended. Move-only.
/// Threads: several may read one view; one at a time moves or ends it (docs/threads.md).
class PatchView {
 public:
  PatchView() noexcept;  ///< Empty: may only be assigned to.
  ~PatchView();
  PatchView(PatchView&&) noexcept;
  PatchView& operator=(PatchView&&) noexcept;

  FaceId face() const noexcept;
  int level() const noexcept;
  /// Steps along a side.
  std::int64_t size() const noexcept;

  /// Errors: kInvalidArgument if the attribute has other records; kNotFound if the reader does not
  /// read it.
  template <class Record>
  AttributeView<Record> attribute(std::string_view name) const& {
    check_record_type<Record>();
    return {slots_of(name, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents), face(),
            refinements()};
  }
  template <class Record>
  AttributeView<Record> attribute(std::string_view name) && {
    AttributeView<Record> view = std::as_const(*this).template attribute<Record>(name);
    view.pins_ = release();
    return view;
  }
  /// The same for records of any type. Errors: kNotFound if the reader does not read it.
  RecordView records(std::string_view name) const&;
  RecordView records(std::string_view name) &&;

 private:
  friend class Reader;
  struct Content;

  int refinements() const noexcept;
  /// The pins without the view, which is then empty. Errors: kOutOfMemory.
  std::shared_ptr<const void> release();
  const FaceSlots& slots_of(std::string_view name, ComponentType type,
                            std::uint32_t components) const;

  std::unique_ptr<Content> content_;
};

/// Records of consecutive vertices, at their addresses in memory (Reader::pin_vertices). The object
/// pins their blocks until it ends, and counts as a view. It may outlive its reader and its store,
/// as a PatchView may. Move-only. Threads: several may read the records; one at a time moves or
/// ends the object (docs/threads.md).
class PinnedVertices {
 public:
  PinnedVertices() noexcept;  ///< Empty: may only be assigned to.
  ~PinnedVertices();
  PinnedVertices(PinnedVertices&&) noexcept;
  PinnedVertices& operator=(PinnedVertices&&) noexcept;

  std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
  friend class Reader;
  struct Content;

  std::unique_ptr<Content> content_;
  std::span<const std::byte> bytes_;
};

/// A level that a face says itself, in a store whose faces have depths of their own.
enum class Depth : std::uint8_t { kOwn };

/// Threads: shared (docs/threads.md). While a store has readers or views, calls that change the
/// same Store object, commit it or close it fail with kBusy. Other Store objects, of this process
/// or another one, may write to the same store: the reader keeps the version that its store has
/// opened.
class Reader {
 public:
  /// Errors: kNotFound for an attribute that the store does not have; kOutOfMemory.
  explicit Reader(const Store& store, const ReaderOptions& options = {});
  ~Reader();
  Reader(Reader&&) noexcept;
  Reader& operator=(Reader&&) noexcept;

  /// Pins all records of face `face` of Store::base() at `level`, of all attributes of the reader.
  /// Errors: kInvalidArgument for a face or a level that is not there (an attribute may have fewer
  /// levels than another one, and a face too: depth()); kBadState for an unfinished level
  /// (Store::commit); kBudget with the number of open views; those of Session::pin_many.
  PatchView read_patch(FaceId face, int level) const;
  /// The same at depth(face).
  PatchView read_patch(FaceId face, Depth) const { return read_patch(face, depth(face)); }
  /// The finest level at which the face can be read: Store::depth(), but not beyond an attribute of
  /// the reader. Errors: kInvalidArgument for a face that is not there.
  int depth(FaceId face) const;
  /// depth() of the face across a side; nothing at a border. The same errors; kInvalidArgument
  /// unless `side` is 0, 1 or 2.
  std::optional<int> depth_across(FaceId face, int side) const;

  /// Calls visit(const PatchView&) for these faces, in this order, and reads the next patches ahead
  /// while `visit` works. Errors: as read_patch(), and those of `visit`.
  template <class Visit>
  void for_each_patch(std::span<const FaceId> faces, int level, Visit visit) const {
    std::size_t ahead = 0;  // the faces before are in memory or on their way
    for (std::size_t at = 0; at < faces.size(); ++at) {
      const PatchView patch = read_patch(faces[at], level);
      ahead = std::max(ahead, at + 1);
      const std::size_t after = std::min(faces.size(), at + 1 + kReadAhead);
      ahead += read_ahead(faces.subspan(ahead, after - ahead), level);
      visit(patch);
    }
  }

  /// Begins to read these patches, which the program will read soon: those in front first, as far
  /// as the budget and the I/O threads have room now, and 64 at most. Returns how many of them are
  /// in memory or on their way; call it again with the others later. The blocks stay in memory
  /// until the patch is read, or until end_prefetch(). With io_threads = 0 nothing is read ahead.
  /// Does nothing for faces and levels that are not there: read_patch() will refuse them.
  std::size_t prefetch(std::span<const FaceId> faces, int level) const noexcept;
  /// The program does not need the patches that it has not read since prefetch(): their blocks can
  /// be evicted, and reads that have not begun are dropped.
  void end_prefetch() const noexcept;
  /// Copies the records of one attribute of these faces to `to`: patch after patch, each in row
  /// order. Reads the next patches ahead. Errors: as read_patch(); kInvalidArgument unless `to` has
  /// faces.size() * patch_vertex_count(size) records.
  void copy_patches(std::string_view attribute, std::span<const FaceId> faces, int level,
                    std::span<std::byte> to) const;
  /// Numbers the vertices of these patches from 0 on, each vertex once, though patches share the
  /// vertices of their common sides. numbers[k * patch_vertex_count(size) + p] becomes the number
  /// of the vertex at place p (row order) of patch faces[k]. Numbers ascend in the order in which
  /// the vertices first appear. Returns how many vertices there are. Errors: kInvalidArgument for a
  /// face that is not there or is named twice, for a level as in patch_indices(), unless `numbers`
  /// has room for all points, and for more than 2^32 - 1 points.
  std::uint64_t weld_patches(std::span<const FaceId> faces, int level,
                             std::span<std::uint32_t> numbers) const;

  /// The faces whose bounds (plait/bounds.h) meet the box or touch it, ascending. The bounds are
  /// those of float32 x 3 or float64 x 3 attribute `attribute`, which the reader must read. The
  /// first call takes them from the file that write_bounds() has written. If there is no such file,
  /// or if it is stale, or if the store is open for writing, the call computes the bounds: it reads
  /// all levels of the attribute once. The reader keeps the bounds in memory, 28 bytes for each
  /// face, in addition to the budget. A query then takes time for the faces that it finds and for
  /// the logarithm of their number, if the layout keeps neighbours together. Errors:
  /// kInvalidArgument for a box with a component that is not a number; kNotFound; kCorruption for a
  /// damaged file; those of Session::pin.
  std::vector<FaceId> faces_in_box(const Box& box, std::string_view attribute = "position") const;
  /// The faces whose bounds the ray meets or touches, the nearest first; at equal distances, in
  /// ascending order. The ray has an origin and no end. Errors: as faces_in_box(); kInvalidArgument
  /// for components that are not finite, and for a direction that is zero.
  std::vector<FaceOnRay> faces_along_ray(Vector3<double> origin, Vector3<double> direction,
                                         std::string_view attribute = "position") const;

  /// The triangles of a patch at `level`, counterclockwise: numbers in row order. They are the same
  /// for all patches. Errors: kInvalidArgument for a level before the base level, and for a level
  /// more than 15 refinements after it.
  std::vector<std::array<std::uint32_t, 3>> patch_indices(int level) const;

  /// Calls visit(vertex, std::span<const Record>) for the vertices `first` to `first` + `count` - 1
  /// of those that `level` creates, with the number of the span's first vertex. There is one span
  /// for each block. The order is that of VertexNumbering (plait/extend/vertex_numbering.h), which
  /// counts from the first vertex of the level here; `level` may be the base level. Reads the next
  /// blocks of the range ahead. Errors: kInvalidArgument; those of Session::pin.
  template <class Record, class Visit>
  void for_each_block(std::string_view attribute, int level, std::uint64_t first,
                      std::uint64_t count, Visit visit) const {
    check_record_type<Record>();
    const std::size_t number =
        number_of(attribute, RecordTraits<Record>::kType, RecordTraits<Record>::kComponents);
    visit_blocks(number, level, first, count,
                 [&](std::uint64_t vertex, std::span<const std::byte> bytes) {
                   visit(vertex, std::span(reinterpret_cast<const Record*>(bytes.data()),
                                           bytes.size() / sizeof(Record)));
                 });
  }
  /// The same for records of any type: calls visit(vertex, std::span<const std::byte>).
  template <class Visit>
  void for_each_block_of_bytes(std::string_view attribute, int level, std::uint64_t first,
                               std::uint64_t count, Visit visit) const {
    visit_blocks(number_of(attribute), level, first, count, visit);
  }
  /// Pins the records of these vertices where the store has them in memory, without a copy: as many
  /// from `first` on as lie one after another, one block at least. Errors: kNotSupported if the
  /// store has no addresses for its blocks: they are those of backend `memory`, and of `mmap` in a
  /// store that was opened for reading; kInvalidArgument, also for count == 0; those of
  /// Session::pin.
  PinnedVertices pin_vertices(std::string_view attribute, int level, std::uint64_t first,
                              std::uint64_t count) const;
  /// The first vertex of each block of a level, ascending: ranges that a program reads best in one
  /// call. The base level is one block. Errors: kNotFound; kInvalidArgument.
  std::vector<std::uint64_t> block_starts(std::string_view attribute, int level) const;
  /// The vertices that `level` creates; of the base level, all of its vertices.
  std::uint64_t vertex_count(int level) const;

  /// Views of this store that have not ended, of all of its readers.
  std::uint64_t view_count() const noexcept;
  PagingStatistics statistics() const;

 private:
  friend class PatchView;
  friend class PinnedVertices;
  friend void write_bounds(const Store& store, std::string_view attribute,
                           const ProgressCallback& progress);
  struct State;
  struct Counted;

  static constexpr std::size_t kReadAhead = 8;  ///< patches
  template <class Visit>
  void visit_blocks(std::size_t number, int level, std::uint64_t first, std::uint64_t count,
                    Visit visit) const {
    check_range(number, level, first, count);
    while (count > 0) {
      PinnedBlock pinned;
      const std::span<const std::byte> bytes = read_vertices(number, level, first, count, pinned);
      visit(first, bytes);
      const std::uint64_t records = bytes.size() / record_bytes(number);
      first += records;
      count -= records;
    }
  }
  /// As prefetch(), but by Session::read_ahead.
  std::size_t read_ahead(std::span<const FaceId> faces, int level) const noexcept;
  std::size_t number_of(std::string_view attribute) const;
  std::size_t number_of(std::string_view attribute, ComponentType type,
                        std::uint32_t components) const;
  std::size_t record_bytes(std::size_t number) const noexcept;
  void check_range(std::size_t number, int level, std::uint64_t first, std::uint64_t count) const;
  /// As many records from vertex `first` on as its block has, `count` at most.
  std::span<const std::byte> read_vertices(std::size_t number, int level, std::uint64_t first,
                                           std::uint64_t count, PinnedBlock& pinned) const;

  std::shared_ptr<const State> state_;
};

PLAIT_END_NAMESPACE
