#include "compressed/filters/hierarchy_filter.h"

#include <fmt/format.h>

#include <optional>

#include "compressed/filters/edge_lattice.h"
#include "compressed/filters/lattice_filter.h"
#include "compressed/filters/residuals.h"
#include "plait/default_arithmetic.h"
#include "plait/error.h"
#include "plait/number_lattice.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct HierarchyOptions {
  PredictionRule rule = PredictionRule::kButterfly;
  std::optional<double> step = {};  ///< of rounded numbers
};

template <class Number, std::size_t kComponents>
class HierarchyFilter final : public Filter {
 public:
  HierarchyFilter(const FilterLevel& level, const HierarchyOptions& options) : rule_(options.rule) {
    if (options.step) numbers_.emplace(*options.step);
    if (level.geometry == nullptr || level.surroundings == nullptr) return;
    for (const AttributeLevels& attribute : level.surroundings->attributes) {
      if (attribute.number != level.attribute) continue;
      const auto coarser = static_cast<std::size_t>(level.geometry->level().refinements - 1);
      if (attribute.levels.size() < coarser) return;
      attribute_ = attribute.number;
      base_level_ = level.surroundings->base_level;
      base_ = attribute.base;
      blocks_.emplace(level.surroundings->mesh,
                      std::vector(attribute.levels.begin(),
                                  attribute.levels.begin() + static_cast<std::ptrdiff_t>(coarser)),
                      *level.geometry);
    }
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
    return blocks_ ? Lattice::bytes(blocks_->own().level().refinements) : 0;
  }

  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const auto* const numbers = reinterpret_cast<const Number*>(raw.data());
    auto* const residuals = reinterpret_cast<BitsOf<Number>*>(filtered.data());
    predict(block,
            [&](const Number* __restrict prediction, std::int64_t first, std::int64_t count) {
              const Number* __restrict const from = numbers + first;
              BitsOf<Number>* __restrict const to = residuals + first;
              if (numbers_)
                for (std::int64_t i = 0; i < count; ++i)
                  to[i] = lattice_residual(*numbers_, from[i], prediction[i]);
              else
                for (std::int64_t i = 0; i < count; ++i) to[i] = residual(from[i], prediction[i]);
            });
  }

  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const auto* const residuals = reinterpret_cast<const BitsOf<Number>*>(filtered.data());
    auto* const numbers = reinterpret_cast<Number*>(raw.data());
    predict(block,
            [&](const Number* __restrict prediction, std::int64_t first, std::int64_t count) {
              const BitsOf<Number>* __restrict const from = residuals + first;
              Number* __restrict const to = numbers + first;
              if (numbers_)
                for (std::int64_t i = 0; i < count; ++i)
                  to[i] = from_lattice_residual(*numbers_, from[i], prediction[i]);
              else
                for (std::int64_t i = 0; i < count; ++i)
                  to[i] = from_residual(from[i], prediction[i]);
            });
  }

 private:
  using Lattice = EdgeLattice<Number, kComponents>;

  /// Calls visit(prediction, first, count) for runs of numbers of the block.
  template <class Visit>
  void predict(const FilterBlock& block, Visit visit) const {
    if (!blocks_)
      throw Error(ErrorCode::kNotSupported,
                  "predict a block from coarser levels: the mesh and these levels are not known");
    const DefaultArithmetic arithmetic;
    const CoarserChoice choice = blocks_->choose(block.block);
    const CoarserSlots slots(*blocks_, choice, block.context);
    const LevelGeometry& level = blocks_->own();
    Lattice lattice(*blocks_, level.level().refinements, base_, rule_, block.scratch);
    const std::uint64_t start = level.block_offset(block.block);
    const EdgeId end = level.edge_after(block.block);
    for (EdgeId edge = level.first_edge(block.block); edge < end; ++edge) {
      const auto at = static_cast<std::int64_t>((level.slot(edge).offset - start) / sizeof(Number));
      lattice.predict(slots, edge, [&](const Number* row, std::int64_t first, std::int64_t count) {
        visit(row, at + first, count);
      });
    }
  }

  PredictionRule rule_;
  std::optional<NumberLattice<Number>> numbers_;  ///< of rounded numbers
  std::uint32_t attribute_ = kNoId;
  int base_level_ = 0;
  std::span<const std::byte> base_;
  std::optional<CoarserBlocks> blocks_;  ///< nothing if the level's surroundings are not known
};

template <class Number>
std::unique_ptr<Filter> make_for(const FilterLevel& level, const HierarchyOptions& options) {
  switch (level.schema.components) {
    case 1:
      return std::make_unique<HierarchyFilter<Number, 1>>(level, options);
    case 2:
      return std::make_unique<HierarchyFilter<Number, 2>>(level, options);
    case 3:
      return std::make_unique<HierarchyFilter<Number, 3>>(level, options);
    case 4:
      return std::make_unique<HierarchyFilter<Number, 4>>(level, options);
    default:
      return nullptr;
  }
}

/// RULE, step=STEP, or RULE:step=STEP.
HierarchyOptions options_of(std::string_view text) {
  HierarchyOptions options;
  constexpr std::string_view kStep = "step=";
  std::string_view rule = text;
  if (const std::size_t at = text.starts_with(kStep) ? 0 : text.find(":step=");
      at != std::string_view::npos) {
    rule = text.substr(0, at);
    options.step = step_from_text("hierarchy", text.substr(at + kStep.size() + (at > 0 ? 1 : 0)));
  }
  if (rule == "butterfly" || text.empty() || text.starts_with(kStep)) return options;
  options.rule = PredictionRule::kMidpoint;
  if (rule == "midpoint") return options;
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("choose filter \"hierarchy:{}\": expected butterfly or midpoint, or "
                          "step=STEP, or one of the rules and :step=STEP",
                          text));
}

}  // namespace

std::unique_ptr<Filter> make_hierarchy_filter(std::string_view options, const FilterLevel& level) {
  const HierarchyOptions chosen = options_of(options);
  const AttributeSchema& schema = level.schema;
  std::unique_ptr<Filter> made;
  if (schema.type == ComponentType::kFloat32) made = make_for<float>(level, chosen);
  if (schema.type == ComponentType::kFloat64) made = make_for<double>(level, chosen);
  if (!made)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("choose filter \"hierarchy\" for '{}': expected records of 1 to 4 "
                            "float32 or float64, found {} x {}",
                            schema.name, schema.components, to_string(schema.type)));
  return made;
}

PLAIT_END_NAMESPACE
