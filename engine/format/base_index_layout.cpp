#include "format/base_index_layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint64_t kArrayAlignment = 4096;

constexpr std::uint64_t aligned(std::uint64_t bytes) {
  return (bytes + kArrayAlignment - 1) / kArrayAlignment * kArrayAlignment;
}

}  // namespace

BaseIndexLayout::BaseIndexLayout(const BaseCounts& counts, IndexMaps maps) {
  const std::array<std::uint64_t, kMeshArrayCount> bytes = {
      24 * counts.vertices,
      12 * counts.faces,
      12 * counts.faces,
      16 * counts.edges,
      4 * counts.vertices,
      4 * counts.border_edges,
      maps.vertices ? 4 * counts.vertices : 0,
      maps.faces ? 4 * counts.faces : 0,
  };
  for (std::size_t at = 0; at < kMeshArrayCount; ++at) {
    places_[at].bytes = bytes[at];
    places_[at].first_page = page_count_;
    page_count_ += places_[at].page_count();
  }
  head_bytes_ = kIndexHeaderBytes + 8 * page_count_ + 8;
  file_bytes_ = aligned(head_bytes_);
  for (Place& place : places_) {
    place.offset = file_bytes_;
    file_bytes_ += aligned(place.bytes);
  }
}

PLAIT_END_NAMESPACE
