// Stores in memory to choose samples of and to try pipelines on.
#pragma once

#include <cstdint>
#include <random>
#include <utility>

#include "paging/level_cursor.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/test_meshes.h"

namespace plait::tune {

/// A smooth surface with normals.
inline Store smooth_store(int levels, std::uint64_t block_bytes = 1 << 16) {
  StoreOptions options;
  options.backend = "memory";
  options.block_bytes = block_bytes;
  Store store =
      Store::create({}, lay_out(BaseMesh::build(test::random_sphere(3, 200)), LayoutKind::kHilbert),
                    options, default_backends());
  add_base_positions(store);
  subdivide(store, {.executor = ExecutorKind::kFused, .levels = levels, .normals = true});
  return store;
}

/// Gives every record of an attribute random bits.
inline void fill_with_random_bits(Store& store, AttributeId id) {
  std::mt19937_64 random(11);
  for (int level = store.base_level() + 1; level <= store.attributes()[id].finest_level; ++level) {
    LevelCursor cursor(StoreAccess::open_session(store), StoreAccess::level_file(store, id, level),
                       Access::kOverwrite);
    for (EdgeId edge = 0; edge < store.base().edge_count(); ++edge)
      for (std::byte& byte : cursor.slot(edge).bytes) byte = static_cast<std::byte>(random());
  }
}

}  // namespace plait::tune
