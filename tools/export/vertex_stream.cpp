#include "export/vertex_stream.h"

#include <algorithm>
#include <utility>

#include "paging/level_cursor.h"
#include "plait/extend/store_access.h"

namespace plait {
namespace {

constexpr std::size_t kBaseRecordsAtOnce = 1024;

void stream_base(Store& store, std::span<const AttributeId> attributes, const VertexSink& sink) {
  std::vector<std::span<const std::byte>> records(attributes.size());
  const std::uint64_t vertices = store.base().vertex_count();
  for (std::uint64_t first = 0; first < vertices; first += kBaseRecordsAtOnce) {
    const std::size_t count = std::min<std::uint64_t>(kBaseRecordsAtOnce, vertices - first);
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const std::size_t bytes = store.attributes()[attributes[i]].schema.record_bytes();
      records[i] =
          std::as_const(store).base_bytes(attributes[i]).subspan(first * bytes, count * bytes);
    }
    sink(records, count);
  }
}

}  // namespace

void stream_vertices(Store& store, std::span<const AttributeId> attributes, int level,
                     const VertexSink& sink) {
  stream_base(store, attributes, sink);
  std::vector<std::span<const std::byte>> records(attributes.size());
  const auto edges = static_cast<EdgeId>(store.base().edge_count());
  for (int finer = store.base_level() + 1; finer <= level; ++finer) {
    std::vector<LevelCursor> cursors;
    for (const AttributeId attribute : attributes)
      cursors.emplace_back(StoreAccess::open_session(store),
                           StoreAccess::level_file(store, attribute, finer));
    for (EdgeId edge = 0; edge < edges; ++edge) {
      for (std::size_t i = 0; i < cursors.size(); ++i) records[i] = cursors[i].slot(edge).bytes;
      sink(records, records[0].size() / cursors[0].geometry().record_bytes());
    }
  }
}

}  // namespace plait
