#include "compressed/filters/hierarchy_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "base/message_text.h"
#include "base/number_lattice.h"
#include "compressed/filters/lattice_filter.h"
#include "compressed/filters/predicting_filter.h"
#include "compressed/filters/residuals.h"
#include "compressed/filters/slot_predictions.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct HierarchyOptions {
  std::optional<PredictionRule> rule = {};  ///< nothing: the best one of each block
  std::optional<double> step = {};          ///< of rounded numbers
};

/// The residuals of every 16th edge choose the rule of a block.
constexpr EdgeId kEdgesOfASample = 16;

template <class Number, std::size_t kComponents>
class HierarchyFilter final : public PredictingFilter<Number, kComponents> {
 public:
  HierarchyFilter(const FilterLevel& level, const HierarchyOptions& options) : rule_(options.rule) {
    if (options.step) numbers_.emplace(*options.step);
    if (level.geometry == nullptr || level.surroundings == nullptr) return;
    const auto coarser = static_cast<std::size_t>(level.geometry->level().refinements - 1);
    for (const AttributeLevels& attribute : level.surroundings->attributes)
      if (attribute.number == level.attribute && attribute.levels.size() >= coarser)
        this->read(level, attribute, coarser);
  }

  bool keeps_note() const noexcept override { return !rule_; }

  std::size_t scratch_bytes() const noexcept override {
    const std::size_t lattice = this->lattice_bytes();
    return lattice + (lattice > 0 && numbers_ ? slot_numbers() * sizeof(Number) : 0);
  }

  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const auto* const numbers = reinterpret_cast<const Number*>(raw.data());
    auto* const residuals = reinterpret_cast<BitsOf<Number>*>(filtered.data());
    const PredictionRule rule = rule_        ? *rule_
                                : block.note ? best_rule(block, numbers, residuals)
                                             : PredictionRule::kButterfly;
    if (block.note != nullptr) *block.note = static_cast<std::byte>(rule);
    visit_slots(block, rule, 1, [&](const Rows& rows, std::size_t first, std::size_t count) {
      encode_slot(block, rows, numbers + first, residuals + first, count);
    });
  }

  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const auto* const residuals = reinterpret_cast<const BitsOf<Number>*>(filtered.data());
    auto* const numbers = reinterpret_cast<Number*>(raw.data());
    visit_slots(block, noted_rule(block), 1,
                [&](const Rows& rows, std::size_t first, std::size_t count) {
                  decode_slot(block, rows, residuals + first, numbers + first, count);
                });
  }

 private:
  using Rows = PredictedRows<Number>;

  std::size_t slot_numbers() const noexcept {
    const auto side = static_cast<std::size_t>(slot_side(this->own().level().refinements));
    return side * side * kComponents;
  }
  /// Room for the predictions of one slot, after the lattice.
  Number* predictions_in(const FilterBlock& block) const noexcept {
    return reinterpret_cast<Number*>(block.scratch.data() + this->lattice_bytes());
  }

  void encode_slot(const FilterBlock& block, const Rows& rows, const Number* from,
                   BitsOf<Number>* to, std::size_t count) const noexcept {
    if (!numbers_) return encode_rows(rows, from, to);
    const Number* __restrict const predictions = predictions_in(block);
    predict_rows(rows, predictions_in(block));
    for (std::size_t i = 0; i < count; ++i)
      to[i] = lattice_residual(*numbers_, from[i], predictions[i]);
  }
  void decode_slot(const FilterBlock& block, const Rows& rows, const BitsOf<Number>* from,
                   Number* to, std::size_t count) const noexcept {
    if (!numbers_) return decode_rows(rows, from, to);
    const Number* __restrict const predictions = predictions_in(block);
    predict_rows(rows, predictions_in(block));
    for (std::size_t i = 0; i < count; ++i)
      to[i] = from_lattice_residual(*numbers_, from[i], predictions[i]);
  }

  /// Calls visit(rows, first number, count) for every `step`-th slot of the block.
  template <class Visit>
  void visit_slots(const FilterBlock& block, PredictionRule rule, EdgeId step, Visit visit) const {
    this->visit_lattices(
        block, step, rule != PredictionRule::kMidpoint,
        [&](EdgeLattice<Number, kComponents>& lattice, const Slot& slot, std::uint64_t begin) {
          visit(Rows{lattice.point(0, 0)->data(),
                     lattice.stride() * std::int64_t{kComponents},
                     lattice.side(),
                     std::int64_t{kComponents},
                     {slot.shape, lattice.is_border()},
                     rule},
                begin / sizeof(Number), slot.bytes / sizeof(Number));
        });
  }

  /// The rule whose residuals have the fewest significant bits. Uses `residuals` as room.
  PredictionRule best_rule(const FilterBlock& block, const Number* numbers,
                           BitsOf<Number>* residuals) const {
    std::array<std::uint64_t, kPredictionRules> bits{};
    visit_slots(block, PredictionRule::kButterfly, kEdgesOfASample,
                [&](Rows rows, std::size_t first, std::size_t count) {
                  for (int rule = 0; rule < kPredictionRules; ++rule) {
                    rows.rule = static_cast<PredictionRule>(rule);
                    encode_slot(block, rows, numbers + first, residuals + first, count);
                    for (std::size_t i = first; i < first + count; ++i)
                      bits[static_cast<std::size_t>(rule)] +=
                          static_cast<std::uint64_t>(std::bit_width(residuals[i]));
                  }
                });
    return static_cast<PredictionRule>(std::ranges::min_element(bits) - bits.begin());
  }
  PredictionRule noted_rule(const FilterBlock& block) const {
    if (rule_) return *rule_;
    if (block.note == nullptr) return PredictionRule::kButterfly;
    const int rule = std::to_integer<int>(*block.note);
    if (rule >= kPredictionRules)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("expected rule 0 to {}, found {}", kPredictionRules - 1, rule));
    return static_cast<PredictionRule>(rule);
  }

  std::optional<PredictionRule> rule_;
  std::optional<NumberLattice<Number>> numbers_;  ///< of rounded numbers
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
  if (text.empty() || text.starts_with(kStep)) return options;
  constexpr std::array<std::pair<std::string_view, PredictionRule>, kPredictionRules> kRules = {
      {{"butterfly", PredictionRule::kButterfly},
       {"loop", PredictionRule::kLoop},
       {"midpoint", PredictionRule::kMidpoint}}};
  for (const auto& [name, named] : kRules)
    if (rule == name) options.rule = named;
  if (options.rule) return options;
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("choose filter \"hierarchy:{}\": expected butterfly, loop or midpoint, or "
                  "step=STEP, or one of the rules and :step=STEP",
                  text_for_message(text)));
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
