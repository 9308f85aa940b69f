// The geometry of a level with any counts. Either it is refused, or its slots and blocks fill the
// level without a gap, at the offsets that 128-bit arithmetic gives.
//
// Input: edges, level, record bytes, block size, then border edges.
#include "plait/extend/level_geometry.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "input_bytes.h"
#include "oracle.h"

using namespace plait;
using namespace plait::fuzz;

namespace {

__extension__ using Wide = unsigned __int128;

/// Where the slot of `edge` must begin, by the formula of docs/format.md.
Wide offset_of(const LevelGeometry& geometry, std::span<const EdgeId> border_edges,
               std::uint64_t edge) {
  const Wide n = Wide{1} << (geometry.level().refinements - 1);
  Wide rank = 0;
  for (const EdgeId border : border_edges) rank += border < edge ? 1 : 0;
  return (edge * n * n - rank * (n * (n - 1) / 2)) * geometry.record_bytes();
}

void check_block(const LevelGeometry& geometry, std::span<const EdgeId> border_edges,
                 std::uint64_t block, std::uint64_t block_bytes) {
  const std::uint64_t first = geometry.first_edge(block), end = geometry.edge_after(block);
  require(first < end && end <= geometry.edge_count());
  require(geometry.block_of(static_cast<EdgeId>(first)) == block);
  require(geometry.block_of(static_cast<EdgeId>(end - 1)) == block);
  require(geometry.block_offset(block) == offset_of(geometry, border_edges, first));
  require(geometry.block_offset(block + 1) == offset_of(geometry, border_edges, end));
  require(geometry.block_bytes(block) > 0);
  require(geometry.block_bytes(block) <= geometry.max_block_bytes());
  require(end - first == 1 || geometry.block_bytes(block) <= block_bytes);
}

void check_edge(const LevelGeometry& geometry, std::span<const EdgeId> border_edges, EdgeId edge) {
  const Slot slot = geometry.slot(edge);
  require(slot.offset == offset_of(geometry, border_edges, edge));
  require(slot.offset + slot.bytes == offset_of(geometry, border_edges, std::uint64_t{edge} + 1));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  InputBytes input(data, size);
  const auto edge_count = input.take<std::uint64_t>();
  const auto level = input.take<std::int32_t>();
  const auto record_bytes = input.take<std::uint64_t>();
  const auto block_bytes = std::uint64_t{1} << input.take_below(64);
  std::vector<EdgeId> border_edges;
  // A set of edges takes memory up to its largest member.
  while (!input.rest().empty()) border_edges.push_back(input.take<EdgeId>() % (1u << 22));
  std::sort(border_edges.begin(), border_edges.end());
  border_edges.erase(std::unique(border_edges.begin(), border_edges.end()), border_edges.end());

  accepts({ErrorCode::kInvalidArgument}, [&] {
    const LevelGeometry geometry(SlotShapes(edge_count, EdgeSet(border_edges)),
                                 BaseRelativeLevel(level), record_bytes, block_bytes);
    require(geometry.total_bytes() == offset_of(geometry, border_edges, edge_count));
    require(geometry.total_bytes() < std::uint64_t{1} << 63);
    require(geometry.block_offset(geometry.block_count()) == geometry.total_bytes());
    if (edge_count == 0) return require(geometry.block_count() == 0);
    const std::uint64_t last_block = geometry.block_count() - 1;
    for (const std::uint64_t block : {std::uint64_t{0}, last_block / 2, last_block})
      check_block(geometry, border_edges, block, block_bytes);
    require(geometry.edge_after(last_block) == edge_count);
    check_edge(geometry, border_edges, static_cast<EdgeId>(edge_count / 2));
    check_edge(geometry, border_edges, static_cast<EdgeId>(edge_count - 1));
    for (std::size_t i = 0; i < std::min<std::size_t>(border_edges.size(), 8); ++i) {
      require(geometry.slot(border_edges[i]).shape == SlotShape::kHalf);
      check_edge(geometry, border_edges, border_edges[i]);
    }
  });
  return 0;
}
