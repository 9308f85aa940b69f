// The levels of one attribute that a PatchWriter fills: which patches are missing, which blocks the
// writer holds, and which of these blocks a call is filling.
#pragma once

#include <array>
#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/face_slots.h"
#include "plait/detail/pinned_level.h"
#include "plait/extend/topology.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A block that a call fills, and how many slots of its patch are in the block.
struct FilledBlock {
  std::uint32_t place;  ///< of the level, among those that have slots
  std::uint32_t slots;
  std::uint64_t block;
};
/// Level after level. Each block is there once.
using FilledBlocks = boost::container::small_vector<FilledBlock, 24>;

/// Levels count how often the base mesh is refined; 0 are the base records. Not safe from several
/// threads, except for slots().
class WrittenAttribute {
 public:
  /// Levels `first` to `last`.
  WrittenAttribute(Store& store, AttributeId id, int first, int last);

  const AttributeSchema& schema() const { return schema_; }
  int first() const { return first_; }
  int last() const { return last_; }
  std::span<const PinnedLevel> held() const { return held_; }

  /// Begins a step of the held levels: oldest_idle() then knows which blocks were needed last.
  void begin_step() noexcept {
    for (PinnedLevel& level : held_) level.begin_step();
  }
  /// Tells that a call needs the blocks of the face's slots at these levels, and lists them.
  /// Returns the bytes of those that are not held.
  std::uint64_t need(FaceId face, int from, int to, FilledBlocks& blocks);
  /// Pins these blocks, which are the needed ones. From here on, the call uses them. Errors: those
  /// of Session::pin_many; then it uses none.
  void use(Session& session, const FilledBlocks& blocks);
  /// The call no longer uses them. Blocks that are full are released.
  void end_use(const FilledBlocks& blocks) noexcept;
  /// The patch is written at these levels, in these blocks.
  void note_written(FaceId face, int from, int to, const FilledBlocks& blocks) noexcept;

  /// The level whose oldest block no call uses and the current step does not need; nullptr if there
  /// is none.
  PinnedLevel* oldest_idle() noexcept;
  void release_all() noexcept;

  /// The slots of a face at these levels, and its corners if the base records are written.
  /// REQUIRES: the call uses them.
  FaceSlots slots(FaceId face, int from, int to) const;

  bool is_written(FaceId face, int level) const { return faces_at(level).written[face]; }
  std::uint64_t missing_faces(int level) const { return faces_at(level).missing; }
  /// The first face that is missing. REQUIRES: missing_faces(level) > 0.
  FaceId first_missing(int level) const;
  LevelFile& file(int level) const { return *blocks_of(level).file; }
  WrittenRecords& base_written() const { return *base_written_; }

 private:
  struct Faces {
    std::vector<bool> written;
    std::uint64_t missing;
  };
  struct Blocks {
    LevelFile* file;
    std::vector<std::uint32_t> to_fill;  ///< [block] halves of slots that are missing
    std::vector<std::uint32_t> users;    ///< [block] calls that are filling it
  };

  const Faces& faces_at(int level) const {
    return faces_[static_cast<std::size_t>(level - first_)];
  }
  std::size_t place_of(int level) const { return static_cast<std::size_t>(level - coarsest_); }
  const Blocks& blocks_of(int level) const { return blocks_[place_of(level)]; }

  AttributeSchema schema_;
  Topology mesh_;
  int first_, last_;
  int coarsest_;               ///< first level that has slots
  std::span<std::byte> base_;  ///< empty unless first_ is 0
  WrittenRecords* base_written_;
  std::vector<Faces> faces_;       ///< [level - first_]
  std::vector<Blocks> blocks_;     ///< [level - coarsest_]
  std::vector<PinnedLevel> held_;  ///< [level - coarsest_]
};

PLAIT_END_NAMESPACE
