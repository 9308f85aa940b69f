#include "compressed/filters/coarser_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// An edge of a face at the block counts as much as this many edges of the next faces: without the
/// first, a slot is predicted badly; without the second, only a little worse.
constexpr std::uint32_t kWeightOfOwnFaces = 4;

/// What an edge weighs whose slot is `coarser` levels above the last one. A vertex that is not
/// known spoils those around it. So a missing slot of the last two levels spoils as good as its
/// whole part of a face, and a missing slot of another level a quarter of what one of the next
/// does.
constexpr std::uint64_t weight_of_level(std::size_t coarser) {
  constexpr std::array<std::uint64_t, 5> kWeights = {32, 32, 16, 4, 1};
  return kWeights[std::min(coarser, kWeights.size() - 1)];
}

/// Counts how often the blocks of one level are needed. Remembers a limited number of blocks, so
/// that it needs no memory from the heap.
class Needs {
 public:
  struct Need {
    std::uint64_t block = 0, weight = 0;
  };

  void begin(std::uint64_t own_block) noexcept { own_block_ = own_block; }
  std::uint64_t own_block() const noexcept { return own_block_; }
  /// The other blocks, in the order in which they were needed first.
  std::span<const Need> others() const noexcept { return std::span(blocks_).first(count_); }

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

 private:
  std::uint64_t own_block_ = 0;
  std::array<Need, 64> blocks_ = {};
  std::size_t count_ = 0, last_ = 0;
};

/// The heaviest needs of all levels, as many as have room.
class Heaviest {
 public:
  explicit Heaviest(std::size_t room) : room_(room) {}

  void add(const CoarserBlock& block, std::uint64_t weight) noexcept {
    std::size_t at = count_;
    while (at > 0 && before(block, weight, entries_[at - 1])) --at;
    if (at == room_) return;
    if (count_ < room_) ++count_;
    for (std::size_t i = count_ - 1; i > at; --i) entries_[i] = entries_[i - 1];
    entries_[at] = {block, weight};
  }
  void append_to(CoarserChoice& choice) const noexcept {
    for (std::size_t i = 0; i < count_; ++i) choice.blocks[choice.count++] = entries_[i].block;
  }

 private:
  struct WeighedBlock {
    CoarserBlock block = {};
    std::uint64_t weight = 0;
  };
  static bool before(const CoarserBlock& block, std::uint64_t weight,
                     const WeighedBlock& other) noexcept {
    if (weight != other.weight) return weight > other.weight;
    if (block.refinement != other.block.refinement)
      return block.refinement > other.block.refinement;
    return block.block < other.block.block;
  }

  std::size_t room_, count_ = 0;
  std::array<WeighedBlock, kMostCoarserBlocks> entries_ = {};
};

}  // namespace

CoarserBlocks::CoarserBlocks(const Topology& mesh, const FaceDepths* depths,
                             std::vector<const LevelGeometry*> levels, const LevelGeometry& own)
    : mesh_(mesh),
      depths_(depths),
      levels_(std::move(levels)),
      own_(&own),
      kept_(own.block_count()) {
  if (levels_.size() > kMostCoarserBlocks)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("predict a level from coarser ones: expected at most {} of them, "
                            "found {}",
                            kMostCoarserBlocks, levels_.size()));
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
  const EdgeId end = own_->edge_after(block);
  EdgeId first = own_->first_edge(block);
  while (first + 1 < end && !own_->has_slot(first)) ++first;
  choice.own_edge = first;
  if (count == 0) return choice;
  std::array<Needs, kMostCoarserBlocks> needs;
  // Edges whose slots are in the blocks of the first edge need no others: most edges.
  EdgeId begin_of_own = 0, end_of_own = kNoId;
  for (std::size_t i = 0; i < count; ++i) {
    needs[i].begin(levels_[i]->block_of(first));
    begin_of_own = std::max(begin_of_own, levels_[i]->first_edge(needs[i].own_block()));
    end_of_own = std::min(end_of_own, levels_[i]->edge_after(needs[i].own_block()));
  }
  const auto add = [&](FaceId face, std::uint32_t weight) {
    for (const EdgeId edge : mesh_.face_edges[face]) {
      if (edge >= begin_of_own && edge < end_of_own) continue;
      for (std::size_t i = 0; i < count; ++i)
        if (levels_[i]->has_slot(edge)) needs[i].add(levels_[i]->block_of(edge), weight);
    }
  };
  for (EdgeId edge = first; edge < end; ++edge) {
    if (!own_->has_slot(edge)) continue;
    for (const FaceSide side : {mesh_.edges[edge].own, mesh_.edges[edge].other}) {
      if (!side.exists()) continue;
      add(side.face(), kWeightOfOwnFaces);
      for (int turn = 1; turn < 3; ++turn) {
        const FaceSide next = mesh_.across(FaceSide(side.face(), (side.side() + turn) % 3));
        if (next.exists()) add(next.face(), 1);
      }
    }
  }
  Heaviest heaviest(kMostCoarserBlocks - count);
  for (std::size_t i = 0; i < count; ++i) {
    const int refinement = static_cast<int>(i) + 1;
    choice.blocks[choice.count++] = {refinement, needs[i].own_block()};
    for (const Needs::Need& need : needs[i].others())
      heaviest.add({refinement, need.block}, need.weight * weight_of_level(count - 1 - i));
  }
  heaviest.append_to(choice);
  std::sort(choice.blocks.begin(),
            choice.blocks.begin() + static_cast<std::ptrdiff_t>(choice.count),
            [](const CoarserBlock& a, const CoarserBlock& b) {
              return a.refinement != b.refinement ? a.refinement < b.refinement : a.block < b.block;
            });
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
    const auto at = static_cast<std::size_t>(refinement);
    // Most slots are in the block of the same edges, so it comes first.
    if (choice.own_edge >= parts_[i].first && choice.own_edge < parts_[i].end)
      std::swap(parts_[i], parts_[begin_[at - 1]]);
    begin_[at] = i + 1;
  }
}

PLAIT_END_NAMESPACE
