// The state of a Reader. All source files of Reader share it.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "execution/reader/bounds_tree.h"
#include "execution/reader/face_bounds.h"
#include "plait/reader.h"
#include "store/store_checks.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct Reader::State : std::enable_shared_from_this<Reader::State> {
  struct Attribute {
    AttributeId id;
    AttributeSchema schema;
    int finest_level;
    std::span<const std::byte> base_bytes;
    std::vector<const LevelFile*> levels;  ///< [refinements of the base mesh - 1]
  };

  State(const Store& of, const ReaderOptions& options);

  /// Errors: kBadState in a process that was forked from the store's.
  void check_usable() const { store->process.check("a reader"); }
  const Attribute* find(std::string_view name) const;
  void check_level(const Attribute& attribute, int level) const;
  /// Throws kBadState for a level that is unfinished.
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
  Topology mesh;
  int base_level = 0;
  std::vector<Attribute> attributes;

  mutable std::mutex trees_mutex;  ///< for `trees`; held while a tree is made
  mutable std::vector<std::shared_ptr<const BoundsTree>> trees;  ///< [attribute of the reader]
};

/// The state as a Reader owns it: counts a reader of the store. Views have the state alone, which
/// they keep after their reader has ended.
struct Reader::Counted {
  explicit Counted(std::shared_ptr<const State> of) : state(std::move(of)) {
    ++state->store->reader_count;
  }
  ~Counted() { --state->store->reader_count; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;

  const std::shared_ptr<const State> state;
};

PLAIT_END_NAMESPACE
