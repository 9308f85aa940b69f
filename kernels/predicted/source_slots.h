// Which blocks of another attribute are around the edges of a block, and where their slots are in
// memory. Levels count refinements of the base mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "plait/extend/block_maker.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The levels `first` to the finest one on all edges of the faces at the edges of a block, and the
/// level `own` on the edges themselves.
class SourceBlocks {
 public:
  /// `levels` of the source, [level - 1]. The geometries outlive this object.
  SourceBlocks(const Topology& mesh, std::vector<const LevelGeometry*> levels, int first, int own)
      : mesh_(mesh), levels_(std::move(levels)), first_(first), own_(own) {}

  struct Block {
    int level = 0;
    std::uint64_t block = 0;
    friend auto operator<=>(const Block&, const Block&) = default;
  };
  /// In ascending order. None if there are more than kMostSourceBlocks.
  struct Choice {
    std::array<Block, kMostSourceBlocks> blocks;
    std::size_t count = 0;
  };
  Choice choose(EdgeId begin, EdgeId end) const noexcept {
    Choice choice;
    bool fits = true;
    std::array<std::uint64_t, kMaxLevel + 1> latest;  // [level] most edges are in the same block
    latest.fill(~std::uint64_t{0});
    const auto add = [&](int level, EdgeId edge) {
      const Block block{level, geometry(level).block_of(edge)};
      if (std::exchange(latest[static_cast<std::size_t>(level)], block.block) == block.block)
        return;
      const auto last = choice.blocks.begin() + static_cast<std::ptrdiff_t>(choice.count);
      if (std::find(choice.blocks.begin(), last, block) != last) return;
      fits = fits && choice.count < choice.blocks.size();
      if (fits) choice.blocks[choice.count++] = block;
    };
    for (EdgeId edge = begin; edge < end && fits; ++edge) {
      add(own_, edge);
      for (const FaceSide side : {mesh_.edges[edge].own, mesh_.edges[edge].other})
        if (side.exists())
          for (const EdgeId around : mesh_.face_edges[side.face()])
            for (int level = first_; level <= finest(); ++level) add(level, around);
    }
    if (!fits) choice.count = 0;
    std::sort(choice.blocks.begin(),
              choice.blocks.begin() + static_cast<std::ptrdiff_t>(choice.count));
    return choice;
  }

  const Topology& mesh() const { return mesh_; }
  int first() const { return first_; }
  int own() const { return own_; }
  int finest() const { return static_cast<int>(levels_.size()); }
  const LevelGeometry& geometry(int level) const {
    return *levels_[static_cast<std::size_t>(level - 1)];
  }

 private:
  Topology mesh_;
  std::vector<const LevelGeometry*> levels_;
  int first_, own_;
};

/// The slots of chosen blocks in memory.
template <class Record>
class SourceSlots {
 public:
  /// REQUIRES: bytes[i] are those of choice.blocks[i].
  SourceSlots(const SourceBlocks& blocks, const SourceBlocks::Choice& choice, SourceBytes bytes)
      : blocks_(blocks) {
    for (std::size_t i = 0; i < choice.count; ++i) {
      const auto [level, block] = choice.blocks[i];
      const LevelGeometry& geometry = blocks.geometry(level);
      parts_[i] = {geometry.first_edge(block), geometry.edge_after(block), bytes[i].data(),
                   geometry.block_offset(block)};
      for (std::size_t after = static_cast<std::size_t>(level); after < begin_.size(); ++after)
        begin_[after] = i + 1;
    }
  }

  /// REQUIRES: the edge is one for which the blocks were chosen.
  SlotRecords<const Record> slot(int level, EdgeId edge) const {
    const Slot slot = blocks_.geometry(level).slot(edge);
    std::size_t at = last_[static_cast<std::size_t>(level)];
    const std::size_t begin = begin_[static_cast<std::size_t>(level - 1)];
    if (at < begin || edge < parts_[at].first || edge >= parts_[at].end) {
      at = begin;
      while (edge < parts_[at].first || edge >= parts_[at].end) ++at;
      last_[static_cast<std::size_t>(level)] = at;
    }
    const std::byte* const records = parts_[at].bytes + (slot.offset - parts_[at].offset);
    return {{reinterpret_cast<const Record*>(records), slot.bytes / sizeof(Record)}, slot.shape};
  }

 private:
  struct ChosenBlock {
    EdgeId first = 0, end = 0;
    const std::byte* bytes = nullptr;
    std::uint64_t offset = 0;
  };
  const SourceBlocks& blocks_;
  std::array<ChosenBlock, kMostSourceBlocks> parts_ = {};
  std::array<std::size_t, kMaxLevel + 1> begin_ = {};         ///< [level] the end of its parts
  mutable std::array<std::size_t, kMaxLevel + 1> last_ = {};  ///< [level] the part of the last slot
};

PLAIT_END_NAMESPACE
