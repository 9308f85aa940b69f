#include "execution/part_digest.h"

#include <algorithm>
#include <string>

#include "execution/slot_hasher.h"
#include "paging/level_cursor.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void add_base_vertices(SlotHasher& hasher, const Store& store, std::span<const VertexId> vertices,
                       AttributeId attribute) {
  const AttributeSchema& schema = store.attributes()[attribute].schema;
  const std::size_t record_bytes = schema.record_bytes();
  const std::span<const std::byte> records = store.base_bytes(attribute);
  for (const VertexId vertex : vertices)
    hasher.add(vertex, vertex, store.base_level(), schema.name,
               records.subspan(vertex * record_bytes, record_bytes));
}

}  // namespace

Digest sum_of(const Digest& a, const Digest& b) {
  const std::uint64_t low = a.low + b.low;
  return {a.high + b.high + (low < a.low ? 1 : 0), low};
}

Digest digest_of_part(const Store& store, std::span<const VertexId> vertices,
                      std::span<const AttributeId> attributes, const ProgressCallback& progress) {
  const StorePass under_way(store);
  SlotHasher hasher;
  const EdgeRange range = StoreAccess::edges(store);
  const std::span<const Edge> edges = store.base().topology().edges;
  std::uint64_t done = 0, total = 0;
  for (const AttributeId id : attributes)
    total += static_cast<std::uint64_t>(store.attributes()[id].finest_level - store.base_level()) *
             (range.after - range.first);
  for (const AttributeId id : attributes) {
    const auto& [schema, finest_level] = store.attributes()[id];
    add_base_vertices(hasher, store, vertices, id);
    for (int level = store.base_level() + 1; level <= finest_level; ++level) {
      StoreAccess::check_readable(store, id, level);
      LevelCursor cursor(StoreAccess::open_session(store),
                         StoreAccess::level_file(store, id, level));
      for (EdgeId edge = range.first; edge < range.after; ++edge, ++done) {
        hasher.add(edges[edge].start, edges[edge].end, level, schema.name, cursor.slot(edge).bytes);
        if (done % 4096 == 0 && progress && !progress({"digest", done, total}))
          throw Error(ErrorCode::kCancelled, "digest: cancelled");
      }
    }
  }
  return hasher.sum();
}

FilledDigest::FilledDigest(Store& store) : store_(store) {
  StoreAccess::set_block_filled(
      store, [this](AttributeId attribute, int level, std::uint64_t block,
                    std::span<const std::byte> bytes) { add(attribute, level, block, bytes); });
}

FilledDigest::~FilledDigest() { StoreAccess::set_block_filled(store_, {}); }

void FilledDigest::add(AttributeId attribute, int level, std::uint64_t block,
                       std::span<const std::byte> bytes) {
  const std::string name = StoreAccess::final_name(store_, attribute);
  const LevelGeometry& geometry = StoreAccess::level_file(store_, attribute, level).geometry;
  const std::span<const Edge> edges = store_.base().topology().edges;
  const std::uint64_t start = geometry.block_offset(block);
  SlotHasher hasher;
  for (EdgeId edge = geometry.first_edge(block); edge < geometry.edge_after(block); ++edge) {
    const Slot slot = geometry.slot(edge);
    hasher.add(edges[edge].start, edges[edge].end, level, name,
               bytes.subspan(slot.offset - start, slot.bytes));
  }
  const std::scoped_lock lock(mutex_);
  sum_ = sum_of(sum_, hasher.sum());
}

Digest FilledDigest::with_base_vertices(std::span<const VertexId> vertices) const {
  SlotHasher hasher;
  for (AttributeId id = 0; id < store_.attributes().size(); ++id)
    add_base_vertices(hasher, store_, vertices, id);
  return sum_of(sum_, hasher.sum());
}

PLAIT_END_NAMESPACE
