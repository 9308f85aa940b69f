#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "compressed/filters/built_in_filters.h"
#include "compressed/filters/predicting_filter.h"
#include "compressed/filters/slot_predictions.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Real>
class NormalsFilter final : public PredictingFilter<Real, 3> {
 public:
  /// `positions` is null if the store is not known.
  NormalsFilter(const FilterLevel& level, const AttributeLevels* positions) {
    if (positions == nullptr) return;
    this->read(level, *positions, static_cast<std::size_t>(level.geometry->level().refinements));
  }

  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    recode(block, raw, filtered, Recode::kEncode);
  }
  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    recode(block, filtered, raw, Recode::kDecode);
  }

 private:
  void recode(const FilterBlock& block, std::span<const std::byte> from, std::span<std::byte> to,
              Recode recode) const {
    const auto* const words = reinterpret_cast<const std::uint32_t*>(from.data());
    auto* const recoded = reinterpret_cast<std::uint32_t*>(to.data());
    visit_slots(block, [&](const NormalRows<Real>& rows, std::size_t first) {
      recode_normals(rows, words + first, recoded + first, recode);
    });
  }
  /// Calls visit(rows, first number) for the slots of the block.
  template <class Visit>
  void visit_slots(const FilterBlock& block, Visit visit) const {
    this->visit_lattices(block, 1, false,
                         [&](EdgeLattice<Real, 3>& lattice, const Slot& slot, std::uint64_t begin) {
                           visit({lattice.point(0, 0)->data(),
                                  3 * lattice.stride(),
                                  lattice.side() / 2,
                                  {slot.shape, lattice.is_border()},
                                  reinterpret_cast<float*>(lattice.spare())},
                                 begin / sizeof(float));
                         });
  }
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
