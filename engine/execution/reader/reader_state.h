// The state of a Reader. All source files of Reader share it.
#pragma once

#include <array>
#include <boost/container/small_vector.hpp>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/contention.h"
#include "execution/reader/bounds_tree.h"
#include "execution/reader/face_bounds.h"
#include "plait/extend/base_relative_level.h"
#include "plait/reader.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct Reader::State {
  struct Attribute {
    AttributeId id;
    AttributeSchema schema;
    int finest_level;
    std::span<const std::byte> base_bytes;
    const WrittenRecords* base_written;
    std::vector<const LevelFile*> levels;  ///< [refinements of the base mesh - 1]
  };

  State(const Store& of, const ReaderOptions& options);

  /// Errors: kBadState in a process that was forked from the store's.
  void check_usable() const { store->process.check("a reader"); }
  const Attribute* find(std::string_view name) const;
  void check_level(const Attribute& attribute, int level) const;
  /// The finest level of the face; kMaxLevel if the store has no depths. REQUIRES: the face is
  /// there.
  int depth(FaceId face) const noexcept;
  /// Errors: kInvalidArgument if the face does not have this level.
  void check_depth(FaceId face, int level) const {
    if (level > depth(face)) [[unlikely]]
      refuse_depth(face, level);
  }
  [[noreturn]] void refuse_depth(FaceId face, int level) const;
  /// This state, for a view, which keeps it. REQUIRES: a reader has the state.
  std::shared_ptr<const State> share() const noexcept { return handles[this_thread_part()].lock(); }
  /// Throws kBadState for a level that is unfinished. Level base_level are the base records.
  void check_finished(const Attribute& attribute, int level) const;
  std::size_t number_of(std::string_view name) const;
  std::size_t number_of(std::string_view name, ComponentType type, std::uint32_t components) const;

  // spatial_queries.cpp
  std::uint64_t bounds_key(const Attribute& attribute) const;
  std::vector<FaceBounds> compute_bounds(const Attribute& attribute,
                                         const ProgressCallback& progress = {}) const;
  /// Made by the first caller. Errors: those of Reader::faces_in_box.
  std::shared_ptr<const BoundsTree> bounds_tree(std::size_t number) const;

  std::shared_ptr<const Store::Implementation> store;
  mutable Session session;  ///< safe from several threads; ends before its store
  Topology mesh;            ///< to be read after store->base.need_face() or topology()
  int base_level = 0;
  std::vector<Attribute> attributes;

  /// Copies for threads of different numbers are counted apart, because views are made often.
  std::array<std::weak_ptr<const State>, kThreadParts> handles;

  mutable std::mutex trees_mutex;  ///< for `trees`; held while a tree is made
  mutable std::vector<std::shared_ptr<const BoundsTree>> trees;  ///< [attribute of the reader]
};

/// The state as a Reader owns it: counts a reader of the store. Views have the state alone, which
/// they keep after their reader has ended.
struct Reader::Counted {
  explicit Counted(const std::shared_ptr<State>& of) : state(of) {
    for (std::size_t part = 0; part < kThreadParts; ++part) {
      const auto kept = std::make_shared<const Kept>(of);
      handles[part] = std::shared_ptr<const State>(kept, of.get());
      of->handles[part] = handles[part];
    }
    ++state->store->reader_count;
  }
  ~Counted() { --state->store->reader_count; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  /// In a cache line that no other handle is counted in.
  struct alignas(64) Kept {
    explicit Kept(std::shared_ptr<const State> of) : state(std::move(of)) {}
    const std::shared_ptr<const State> state;
  };

  const std::shared_ptr<const State> state;
  std::array<std::shared_ptr<const State>, kThreadParts> handles;
};

/// The pins of a view, and where its records are.
struct PatchView::Content {
  Content(std::shared_ptr<const Reader::State> of, FaceId of_face, int of_level)
      : state(std::move(of)), face(of_face), level(of_level), slots(state->attributes.size()) {
    ++state->store->view_count;
  }
  ~Content() {
    PinnedBlock::release_all({pins.data(), pins.size()});
    --state->store->view_count;
  }
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;

  int refinements() const { return relative_to_base(level, state->base_level).refinements; }

  std::shared_ptr<const Reader::State> state;  ///< outlives the pins
  FaceId face;
  int level;
  std::vector<FaceSlots> slots;  ///< [attribute of the reader]
  boost::container::small_vector<PinnedBlock, 16> pins;
};

PLAIT_END_NAMESPACE
