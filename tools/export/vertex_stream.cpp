#include "export/vertex_stream.h"

#include <algorithm>

namespace plait {
namespace {

constexpr std::size_t kBaseRecordsAtOnce = 1024;

/// Slots of one level of one attribute in edge order.
class SlotReader {
 public:
  SlotReader(const Store& store, const LevelFile& file)
      : session_(store.open_session()), file_(file) {}

  /// Valid until the next call.
  std::span<const std::byte> slot(EdgeId edge) {
    const LevelGeometry& geometry = file_.geometry;
    const std::uint64_t block = geometry.block_of(edge);
    if (!pinned_ || block != block_) {
      pinned_.release();
      pinned_ = session_.pin(file_, block);
      block_ = block;
    }
    return pinned_.bytes().subspan(geometry.slot_offset(edge) - geometry.block_offset(block),
                                   geometry.slot_bytes(edge));
  }
  std::size_t record_bytes() const { return file_.geometry.record_bytes(); }

 private:
  Session session_;
  const LevelFile& file_;
  PinnedBlock pinned_;
  std::uint64_t block_ = 0;
};

void stream_base(Store& store, std::span<const AttributeId> attributes, const VertexSink& sink) {
  std::vector<std::span<const std::byte>> records(attributes.size());
  const std::uint64_t vertices = store.base().vertex_count();
  for (std::uint64_t first = 0; first < vertices; first += kBaseRecordsAtOnce) {
    const std::size_t count = std::min<std::uint64_t>(kBaseRecordsAtOnce, vertices - first);
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const std::size_t bytes = store.attributes()[attributes[i]].schema.record_bytes();
      records[i] = store.base_bytes(attributes[i]).subspan(first * bytes, count * bytes);
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
    std::vector<SlotReader> readers;
    for (const AttributeId attribute : attributes)
      readers.emplace_back(store, store.level_file(attribute, finer));
    for (EdgeId edge = 0; edge < edges; ++edge) {
      for (std::size_t i = 0; i < readers.size(); ++i) records[i] = readers[i].slot(edge);
      sink(records, records[0].size() / readers[0].record_bytes());
    }
  }
}

}  // namespace plait
