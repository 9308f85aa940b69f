// Levels of one attribute in memory, with the surroundings that a filter needs to predict a block.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/detail/face_depths.h"
#include "plait/extend/edge_index.h"
#include "plait/extend/filter.h"

namespace plait::test {

/// `Number`s, three of them a vertex, in levels 1 to `finest` of a mesh.
template <class Number>
class PredictedLevels {
 public:
  static constexpr std::size_t kComponents = 3;
  using Record = std::array<Number, kComponents>;

  PredictedLevels(BaseMesh base, int finest, std::uint64_t block_bytes)
      : mesh(std::move(base)), base_records(mesh.vertex_count()) {
    for (int level = 1; level <= finest; ++level) {
      geometries.push_back(std::make_unique<LevelGeometry>(
          mesh.geometry(BaseRelativeLevel(level), sizeof(Record), block_bytes)));
      records.emplace_back(geometries.back()->total_bytes() / sizeof(Record));
    }
    surroundings.mesh = mesh.topology();
    surroundings.depths = mesh.depths();
    AttributeLevels& own = surroundings.attributes.emplace_back();
    own.schema.type = sizeof(Number) == 4 ? ComponentType::kFloat32 : ComponentType::kFloat64;
    own.base = std::as_bytes(std::span(base_records));
    for (const auto& geometry : geometries) own.levels.push_back(geometry.get());
  }
  PredictedLevels(const PredictedLevels&) = delete;
  PredictedLevels& operator=(const PredictedLevels&) = delete;

  /// Fills all records with what `next` gives.
  template <class Next>
  void fill(Next next) {
    const auto fill_each = [&](std::vector<Record>& all) {
      for (Record& record : all)
        for (Number& number : record) number = next();
    };
    fill_each(base_records);
    for (auto& level : records) fill_each(level);
  }

  const LevelGeometry& geometry(int level) const {
    return *geometries[static_cast<std::size_t>(level - 1)];
  }
  std::span<const std::byte> block(int level, std::uint64_t block) const {
    return std::as_bytes(std::span(records[static_cast<std::size_t>(level - 1)]))
        .subspan(geometry(level).block_offset(block), geometry(level).block_bytes(block));
  }
  FilterLevel filter_level(int level) const {
    return {.schema = surroundings.attributes[0].schema,
            .geometry = &geometry(level),
            .level = level,
            .surroundings = &surroundings};
  }
  const Record& vertex(const FaceIndex& point) const {
    if (is_corner(point.level, point.i, point.j)) {
      const auto corner = static_cast<std::size_t>(corner_of(point.i, point.j));
      return base_records[mesh.faces()[point.face][corner]];
    }
    const EdgeIndex at = in_frame_of_slot(edge_index(surroundings.mesh, point));
    const Slot slot = geometry(at.level).slot(at.edge);
    return records[static_cast<std::size_t>(at.level - 1)]
                  [slot.offset / sizeof(Record) + static_cast<std::uint64_t>(slot_position(
                                                      at.level, slot.shape, at.row, at.column))];
  }

  /// Whether the edge's slot at a level has the frame of its other face.
  bool is_turned(int level, EdgeId edge) const {
    return mesh.depths() != nullptr && geometry(level).slot(edge).shape == SlotShape::kHalf &&
           mesh.depths()->of(mesh.edges()[edge].own.face()) < level;
  }
  /// From the edge's own frame to that of the slot, or back.
  EdgeIndex in_frame_of_slot(EdgeIndex at) const {
    if (!is_turned(at.level, at.edge)) return at;
    const std::int64_t last = slot_side(at.level) - 1;
    return {at.edge, at.level, last - at.row, last - at.column};
  }
  /// Calls visit(index in the edge's own frame) for the records of a level, in the order of slots.
  template <class Visit>
  void for_each_record(int level, Visit visit) const {
    const std::int64_t n = slot_side(level);
    for (EdgeId edge = 0; edge < mesh.edge_count(); ++edge) {
      const SlotShape shape = geometry(level).slot(edge).shape;
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < row_records(shape, n, row); ++column)
          visit(in_frame_of_slot({edge, level, row, column}));
    }
  }

  BaseMesh mesh;
  std::vector<Record> base_records;
  std::vector<std::unique_ptr<LevelGeometry>> geometries;
  std::vector<std::vector<Record>> records;
  LevelSurroundings surroundings;
};

/// What a filter made of a block, with all that it took to make it.
struct FilteredBlock {
  std::array<ContextBlock, kMostContextBlocks> needed = {};
  std::size_t needed_count = 0;
  std::vector<std::span<const std::byte>> context = {};
  std::vector<std::byte> scratch = {}, filtered = {}, back = {};
  std::byte note = {};
};

/// Encodes a block with its context, and decodes the result.
template <class Number>
FilteredBlock encode_and_decode(const Filter& filter, const PredictedLevels<Number>& levels,
                                int level, std::uint64_t block) {
  FilteredBlock result;
  result.needed_count = filter.context(block, result.needed);
  for (const ContextBlock& needed : std::span(result.needed).first(result.needed_count))
    result.context.push_back(levels.block(needed.level, needed.block));
  result.scratch.resize(filter.scratch_bytes());
  const std::span<const std::byte> raw = levels.block(level, block);
  result.filtered.resize(raw.size());
  result.back.resize(raw.size());
  const FilterBlock with{block, result.context, result.scratch, &result.note};
  filter.encode(with, raw, result.filtered);
  filter.decode(with, result.filtered, result.back);
  return result;
}

}  // namespace plait::test
