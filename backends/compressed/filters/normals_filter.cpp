#include "compressed/filters/normals_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "compressed/filters/edge_lattice.h"
#include "compressed/filters/slot_predictions.h"
#include "plait/default_arithmetic.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
class NormalsFilter final : public Filter {
 public:
  /// `positions` is null if the store is not known.
  NormalsFilter(const FilterLevel& level, const AttributeLevels* positions) {
    if (positions == nullptr) return;
    const auto count = static_cast<std::size_t>(level.geometry->level().refinements);
    attribute_ = positions->number;
    base_level_ = level.surroundings->base_level;
    base_ = positions->base;
    blocks_.emplace(level.surroundings->mesh,
                    std::vector(positions->levels.begin(),
                                positions->levels.begin() + static_cast<std::ptrdiff_t>(count)),
                    *level.geometry);
    places_.emplace(level.geometry->level().refinements + 1, 3 * sizeof(Real));
  }

  bool needs_other_blocks() const noexcept override { return true; }
  std::uint32_t base_attribute() const noexcept override { return attribute_; }

  std::size_t context(std::uint64_t block,
                      std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept override {
    if (!blocks_) return 0;
    const CoarserChoice choice = blocks_->choose(block);
    for (std::size_t i = 0; i < choice.count; ++i)
      blocks[i] = {attribute_, base_level_ + choice.blocks[i].refinement, choice.blocks[i].block};
    return choice.count;
  }

  std::size_t scratch_bytes() const noexcept override {
    return blocks_ ? Lattice::bytes(blocks_->own().level().refinements + 1) : 0;
  }

  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const auto* const normals = reinterpret_cast<const float*>(raw.data());
    auto* const residuals = reinterpret_cast<std::uint32_t*>(filtered.data());
    visit_slots(block, [&](const NormalRows<Real>& rows, std::size_t first) {
      encode_normals(rows, normals + first, residuals + first);
    });
  }

  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const auto* const residuals = reinterpret_cast<const std::uint32_t*>(filtered.data());
    auto* const normals = reinterpret_cast<float*>(raw.data());
    visit_slots(block, [&](const NormalRows<Real>& rows, std::size_t first) {
      decode_normals(rows, residuals + first, normals + first);
    });
  }

 private:
  using Lattice = EdgeLattice<Real, 3>;

  /// Calls visit(rows, first number) for the slots of the block.
  template <class Visit>
  void visit_slots(const FilterBlock& block, Visit visit) const {
    if (!blocks_)
      throw Error(ErrorCode::kNotSupported,
                  "predict normals from positions: the mesh and the positions are not known");
    const DefaultArithmetic arithmetic;
    const CoarserChoice choice = blocks_->choose(block.block);
    const CoarserSlots slots(*blocks_, choice, block.context);
    const LevelGeometry& level = blocks_->own();
    const EdgeRange edges{level.first_edge(block.block), level.edge_after(block.block), 1};
    Lattice lattice(*blocks_, slots, *places_, base_, block.scratch, edges, false);
    const std::uint64_t start = level.block_offset(block.block);
    while (lattice.next())
      visit({lattice.point(0, 0)->data(), 3 * lattice.stride(), lattice.side() / 2,
             lattice.is_border(), reinterpret_cast<float*>(lattice.spare())},
            (level.slot(lattice.edge()).offset - start) / sizeof(float));
  }

  std::uint32_t attribute_ = kNoId;
  int base_level_ = 0;
  std::span<const std::byte> base_;
  // Nothing if the level's surroundings are not known.
  std::optional<CoarserBlocks> blocks_;
  std::optional<LatticePlaces> places_;
};

/// The levels of the positions; null if the store is not known.
const AttributeLevels* positions_in(const FilterLevel& level, std::string_view name) {
  if (level.geometry == nullptr || level.surroundings == nullptr) return nullptr;
  const auto& attributes = level.surroundings->attributes;
  const auto found = std::ranges::find_if(
      attributes, [&](const AttributeLevels& each) { return each.schema.name == name; });
  const auto needed = static_cast<std::size_t>(level.geometry->level().refinements);
  if (found == attributes.end() || found->schema.components != 3 ||
      (found->schema.type != ComponentType::kFloat32 &&
       found->schema.type != ComponentType::kFloat64) ||
      found->levels.size() < needed || found->number >= level.attribute)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("choose filter \"normals\" for level {} of '{}': expected an earlier "
                            "attribute '{}' of 3 float32 or float64 with this level",
                            level.level, level.schema.name, name));
  return &*found;
}

}  // namespace

std::unique_ptr<Filter> make_normals_filter(std::string_view options, const FilterLevel& level) {
  const AttributeSchema& schema = level.schema;
  if (schema.type != ComponentType::kFloat32 || schema.components != 3)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("choose filter \"normals\" for '{}': expected records of 3 float32, "
                            "found {} x {}",
                            schema.name, schema.components, to_string(schema.type)));
  const AttributeLevels* const positions =
      positions_in(level, options.empty() ? std::string_view("position") : options);
  if (positions != nullptr && positions->schema.type == ComponentType::kFloat64)
    return std::make_unique<NormalsFilter<double>>(level, positions);
  return std::make_unique<NormalsFilter<float>>(level, positions);
}

PLAIT_END_NAMESPACE
