// The state of a Reader. All source files of Reader share it.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <string_view>
#include <vector>

#include "execution/reader/bounds_tree.h"
#include "execution/reader/face_bounds.h"
#include "plait/reader.h"
#include "store/store_state.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct Reader::State {
  struct Attribute {
    AttributeId id;
    AttributeSchema schema;
    int finest_level;
    std::span<const std::byte> base_bytes;  ///< of a stored attribute
    std::vector<const LevelFile*> levels;   ///< [refinements of the base mesh - 1]
  };

  State(const Store& of, const ReaderOptions& options);

  const Attribute* find(std::string_view name) const;
  /// Those of a derived attribute are computed by the first call.
  std::span<const std::byte> base_bytes(const Attribute& attribute) const;
  void check_level(const Attribute& attribute, int level) const;
  std::size_t number_of(std::string_view name) const;
  std::size_t number_of(std::string_view name, ComponentType type, std::uint32_t components) const;

  // spatial_queries.cpp
  std::uint64_t bounds_key(const Attribute& attribute) const;
  std::vector<FaceBounds> compute_bounds(const Attribute& attribute,
                                         const BoundsProgress& proceed = {}) const;
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

PLAIT_END_NAMESPACE
