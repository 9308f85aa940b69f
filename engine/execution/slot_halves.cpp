#include "execution/slot_halves.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "plait/error.h"

namespace plait {

HalfShape::HalfShape(const Store& store, std::span<const AttributeId> attributes, int finest)
    : levels(finest) {
  constexpr std::size_t kAlignment = 64, kRoom = 16;
  for (const AttributeId id : attributes) {
    const AttributeSchema& schema = store.attributes()[id].schema;
    outputs.push_back(
        {schema.components, component_bytes(schema.type), schema.record_bytes(), bytes});
    for (int level = 1; level <= finest; ++level)
      bytes += slot_records(level, true) * schema.record_bytes();
    bytes = (bytes + kRoom + kAlignment - 1) / kAlignment * kAlignment;
  }
}

void HalfPool::Unmap::operator()(std::byte* memory) const { ::munmap(memory, bytes); }

std::byte* HalfPool::take() {
  if (vacant_.empty()) {
    // Whole huge pages: one fault instead of hundreds.
    constexpr std::size_t kHugePage = 2 << 20;
    const std::size_t bytes = (half_bytes_ + kHugePage - 1) / kHugePage * kHugePage;
    void* const memory =
        ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw system_error("map", "memory for slots under way", errno);
    slabs_.emplace_back(static_cast<std::byte*>(memory), Unmap{bytes});
    ::madvise(memory, bytes, MADV_HUGEPAGE);
    for (std::size_t at = bytes / half_bytes_; at-- > 0;)
      vacant_.push_back(slabs_.back().get() + at * half_bytes_);
  }
  std::byte* const half = vacant_.back();
  vacant_.pop_back();
  return half;
}

HalfScatter::HalfScatter(const PatchLattice& lattice, const HalfShape& shape) : shape_(shape) {
  for (int side = 0; side < 3; ++side)
    for (int level = 1; level <= shape.levels; ++level) {
      const std::int64_t n = slot_side(level), scale = std::int64_t{1} << (shape.levels - level);
      Points& points = points_[static_cast<std::size_t>(side)];
      const auto add = [&](std::vector<std::uint32_t>& to, std::int64_t row, std::int64_t column) {
        const FaceIndex at = from_side(0, {side, level, row, column});
        to.push_back(static_cast<std::uint32_t>(lattice.index(at.i * scale, at.j * scale)));
      };
      for (std::int64_t row = 0; row < n; ++row) {
        for (std::int64_t column = 0; column < n - row; ++column) add(points.own, row, column);
        for (std::int64_t column = n - row; column < n; ++column)
          add(points.other, n - 1 - row, n - 1 - column);
      }
    }
}

}  // namespace plait
