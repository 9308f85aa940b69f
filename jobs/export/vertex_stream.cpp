#include "export/vertex_stream.h"

#include <algorithm>
#include <utility>

#include "maintenance/half_of_slot.h"
#include "paging/level_cursor.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kBaseRecordsAtOnce = 1024;

using Bytes = std::vector<std::byte>;

void append(Bytes& to, std::span<const std::byte> records) {
  to.insert(to.end(), records.begin(), records.end());
}

void stream_base(Store& store, std::span<const AttributeId> attributes,
                 std::span<const VertexId> vertices, const VertexSink& sink) {
  std::vector<Bytes> gathered(attributes.size());
  std::vector<std::span<const std::byte>> records(attributes.size());
  while (!vertices.empty()) {
    const std::size_t count = std::min(kBaseRecordsAtOnce, vertices.size());
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const std::size_t bytes = store.attributes()[attributes[i]].schema.record_bytes();
      const std::span<const std::byte> base = std::as_const(store).base_bytes(attributes[i]);
      gathered[i].clear();
      for (const VertexId vertex : vertices.first(count))
        append(gathered[i], base.subspan(vertex * bytes, bytes));
      records[i] = gathered[i];
    }
    sink(records, count);
    vertices = vertices.subspan(count);
  }
}

void stream_level(Store& store, std::span<const AttributeId> attributes,
                  const PatchSelection& patches, int refinement, const VertexSink& sink) {
  const int level = store.base_level() + refinement;
  std::vector<LevelCursor> cursors;
  for (const AttributeId attribute : attributes)
    cursors.emplace_back(StoreAccess::open_session(store),
                         StoreAccess::level_file(store, attribute, level));
  std::vector<Bytes> halves(attributes.size());
  std::vector<std::span<const std::byte>> records(attributes.size());
  const auto edges = static_cast<EdgeId>(store.base().edge_count());
  for (EdgeId edge = 0; edge < edges; ++edge) {
    const SlotShape shape = patches.shape(edge, BaseRelativeLevel(refinement));
    if (shape == SlotShape::kAbsent) continue;
    for (std::size_t i = 0; i < cursors.size(); ++i) {
      const LocatedSlot slot = cursors[i].slot(edge);
      records[i] = slot.bytes;
      if (slot.shape == shape) continue;
      const std::size_t bytes = cursors[i].geometry().record_bytes();
      halves[i].resize(slot_records(refinement, SlotShape::kHalf) * bytes);
      copy_half_of_slot(slot.bytes, bytes, refinement,
                        patches.has_own_face(edge, BaseRelativeLevel(refinement)), halves[i]);
      records[i] = halves[i];
    }
    sink(records, records[0].size() / cursors[0].geometry().record_bytes());
  }
}

}  // namespace

void stream_vertices(Store& store, std::span<const AttributeId> attributes,
                     const PatchSelection& patches, const VertexSink& sink) {
  stream_base(store, attributes, patches.base_vertices(), sink);
  for (int refinement = 1; refinement <= patches.refinements(); ++refinement)
    stream_level(store, attributes, patches, refinement, sink);
}

void stream_vertices(Store& store, std::span<const AttributeId> attributes, int level,
                     const VertexSink& sink) {
  stream_vertices(
      store, attributes,
      PatchSelection(store.base(), relative_to_base(level, store.base_level()).refinements,
                     all_faces(store.base())),
      sink);
}

PLAIT_END_NAMESPACE
