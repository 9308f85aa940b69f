#include "compressed/filters/coarser_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

// On a closed mesh of 26,000 vertices in Hilbert order, with blocks of 1 MiB, up to 8 blocks of the
// last level and 4 of each other left out 2 of 1,000 faces at most; 4 and 2 left out 4 of 100.
constexpr std::size_t kMostOfLast = 6, kMostOfOthers = 3;
/// An edge of a face at the block counts as much as this many edges of the next faces: without the
/// first, a slot is predicted badly; without the second, only a little worse.
constexpr std::uint32_t kWeightOfOwnFaces = 4;

/// Counts how often the blocks of one level are needed. Remembers a limited number of blocks, so
/// that it needs no memory from the heap.
class Needs {
 public:
  void begin(std::uint64_t own_block) noexcept {
    own_block_ = own_block;
    count_ = 0;
  }
  void add(std::uint64_t block, std::uint32_t weight) noexcept {
    if (block == own_block_) return;
    if (last_ < count_ && blocks_[last_].block == block) {
      blocks_[last_].weight += weight;
      return;
    }
    for (last_ = 0; last_ < count_; ++last_)
      if (blocks_[last_].block == block) {
        blocks_[last_].weight += weight;
        return;
      }
    if (count_ < blocks_.size()) blocks_[count_++] = {block, weight};
  }
  /// Appends the own block and the most needed ones to `choice`, `most` at most, by their numbers.
  void choose(std::size_t most, int refinement, CoarserChoice& choice) noexcept {
    const auto end = blocks_.begin() + static_cast<std::ptrdiff_t>(count_);
    std::sort(blocks_.begin(), end, [](const Need& a, const Need& b) {
      return a.weight != b.weight ? a.weight > b.weight : a.block < b.block;
    });
    const std::size_t first = choice.count;
    choice.blocks[choice.count++] = {refinement, own_block_};
    for (std::size_t i = 0; i < count_ && i + 1 < most; ++i)
      choice.blocks[choice.count++] = {refinement, blocks_[i].block};
    std::sort(choice.blocks.begin() + static_cast<std::ptrdiff_t>(first),
              choice.blocks.begin() + static_cast<std::ptrdiff_t>(choice.count),
              [](const CoarserBlock& a, const CoarserBlock& b) { return a.block < b.block; });
  }

 private:
  struct Need {
    std::uint64_t block = 0;
    std::uint32_t weight = 0;
  };
  std::uint64_t own_block_ = 0;
  std::array<Need, 64> blocks_ = {};
  std::size_t count_ = 0, last_ = 0;
};

}  // namespace

CoarserBlocks::CoarserBlocks(const Topology& mesh, std::vector<const LevelGeometry*> levels,
                             const LevelGeometry& own)
    : mesh_(mesh), levels_(std::move(levels)), own_(&own), kept_(own.block_count()) {
  if (levels_.size() > kMostContextBlocks)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("predict a level from coarser ones: expected at most {} of them, "
                            "found {}",
                            kMostContextBlocks, levels_.size()));
  if (levels_.empty()) return;
  const std::size_t others = levels_.size() - 1;
  most_of_last_ = std::min(kMostOfLast, kMostContextBlocks - others);
  if (others > 0)
    most_of_others_ =
        std::clamp<std::size_t>((kMostContextBlocks - most_of_last_) / others, 1, kMostOfOthers);
}

CoarserBlocks::~CoarserBlocks() {
  for (const auto& kept : kept_) delete kept.load();
}

CoarserChoice CoarserBlocks::choose(std::uint64_t block) const noexcept {
  if (const CoarserChoice* const kept = kept_[block].load(std::memory_order_acquire)) return *kept;
  const CoarserChoice choice = compute(block);
  // Without memory, the next call computes it again.
  if (auto made = std::unique_ptr<const CoarserChoice>(new (std::nothrow) CoarserChoice(choice))) {
    const CoarserChoice* expected = nullptr;
    if (kept_[block].compare_exchange_strong(expected, made.get(), std::memory_order_release))
      static_cast<void>(made.release());
  }
  return choice;
}

CoarserChoice CoarserBlocks::compute(std::uint64_t block) const noexcept {
  CoarserChoice choice;
  const std::size_t count = levels_.size();
  if (count == 0) return choice;
  const EdgeId first = own_->first_edge(block), end = own_->edge_after(block);
  std::array<Needs, kMostContextBlocks> needs;
  for (std::size_t i = 0; i < count; ++i) needs[i].begin(levels_[i]->block_of(first));
  const auto add = [&](FaceId face, std::uint32_t weight) {
    for (const EdgeId edge : mesh_.face_edges[face]) {
      for (std::size_t i = 0; i < count; ++i) needs[i].add(levels_[i]->block_of(edge), weight);
    }
  };
  for (EdgeId edge = first; edge < end; ++edge)
    for (const FaceSide side : {mesh_.edges[edge].own, mesh_.edges[edge].other}) {
      if (!side.exists()) continue;
      add(side.face(), kWeightOfOwnFaces);
      for (int turn = 1; turn < 3; ++turn) {
        const FaceSide next = mesh_.across(FaceSide(side.face(), (side.side() + turn) % 3));
        if (next.exists()) add(next.face(), 1);
      }
    }
  for (std::size_t i = 0; i < count; ++i)
    needs[i].choose(i + 1 == count ? most_of_last_ : most_of_others_, static_cast<int>(i) + 1,
                    choice);
  return choice;
}

CoarserSlots::CoarserSlots(const CoarserBlocks& blocks, const CoarserChoice& choice,
                           std::span<const std::span<const std::byte>> context) noexcept
    : blocks_(blocks) {
  for (std::size_t i = 0; i < choice.count; ++i) {
    const auto [refinement, block] = choice.blocks[i];
    const LevelGeometry& level = blocks.level(refinement);
    parts_[i] = {level.first_edge(block), level.edge_after(block), context[i].data(),
                 level.block_offset(block)};
    begin_[static_cast<std::size_t>(refinement)] = i + 1;
  }
}

PLAIT_END_NAMESPACE
