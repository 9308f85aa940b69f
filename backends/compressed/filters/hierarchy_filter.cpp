#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "base/number_lattice.h"
#include "base/text.h"
#include "compressed/filters/built_in_filters.h"
#include "compressed/filters/predicting_filter.h"
#include "compressed/filters/residuals.h"
#include "compressed/filters/slot_predictions.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct HierarchyOptions {
  std::optional<PredictionRule> rule = {};  ///< nothing: the best one of each block
  std::optional<double> step = {};          ///< of rounded numbers
  bool along_normals = false;               ///< also try vertices that move along the normal
};

/// How a block is predicted. Its note: the rule, or kPredictionRules more for `along_normals`.
struct Prediction {
  PredictionRule rule = PredictionRule::kButterfly;
  bool along_normals = false;
};

/// The residuals of every 16th edge choose the rule of a block.
constexpr EdgeId kEdgesOfASample = 16;

template <class Number, std::size_t kComponents>
class HierarchyFilter final : public PredictingFilter<Number, kComponents> {
 public:
  HierarchyFilter(const FilterLevel& level, const HierarchyOptions& options)
      : rule_(options.rule), along_normals_(options.along_normals) {
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
    return lattice +
           (lattice > 0 && (numbers_ || along_normals_) ? slot_numbers() * sizeof(Number) : 0);
  }

  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const auto* const numbers = reinterpret_cast<const Word*>(raw.data());
    auto* const residuals = reinterpret_cast<Word*>(filtered.data());
    if (!rule_ && block.note != nullptr)
      *block.note = static_cast<std::byte>(best_note(block, numbers, residuals));
    recode(block, numbers, residuals, Recode::kEncode);
  }
  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    recode(block, reinterpret_cast<const Word*>(filtered.data()),
           reinterpret_cast<Word*>(raw.data()), Recode::kDecode);
  }

 private:
  using Word = BitsOf<Number>;
  using Rows = PredictedRows<Number>;

  std::size_t slot_numbers() const noexcept {
    const auto side = static_cast<std::size_t>(slot_side(this->own().level().refinements));
    return side * side * kComponents;
  }
  /// Room for the predictions of one slot, after the lattice.
  Number* predictions_in(const FilterBlock& block) const noexcept {
    return reinterpret_cast<Number*>(block.scratch.data() + this->lattice_bytes());
  }

  void recode(const FilterBlock& block, const Word* from, Word* to, Recode recode) const {
    const Prediction prediction = noted_prediction(block);
    visit_slots(block, prediction.rule, 1,
                [&](const Rows& rows, std::size_t first, std::size_t count) {
                  recode_slot(block, rows, prediction.along_normals, from + first, to + first,
                              count, recode);
                });
  }
  void recode_slot(const FilterBlock& block, const Rows& rows, bool along_normals, const Word* from,
                   Word* to, std::size_t count, Recode recode) const noexcept {
    if (!numbers_ && !along_normals) return recode_rows(rows, from, to, recode);
    const Number* __restrict const predictions = predictions_in(block);
    predict_rows(rows, predictions_in(block));
    if (along_normals) return recode_along_normals(rows, predictions, from, to, recode);
    if (recode == Recode::kEncode)
      for (std::size_t i = 0; i < count; ++i)
        to[i] = lattice_residual(*numbers_, std::bit_cast<Number>(from[i]), predictions[i]);
    else
      for (std::size_t i = 0; i < count; ++i)
        to[i] = std::bit_cast<Word>(from_lattice_residual(*numbers_, from[i], predictions[i]));
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

  int count_notes() const noexcept {
    return along_normals_ ? 2 * kPredictionRules : kPredictionRules;
  }
  static Prediction prediction_of(int note) noexcept {
    return {static_cast<PredictionRule>(note % kPredictionRules), note >= kPredictionRules};
  }

  /// The note whose residuals have the fewest significant bits. Uses `residuals` as room.
  int best_note(const FilterBlock& block, const Word* numbers, Word* residuals) const {
    std::array<std::uint64_t, 2 * kPredictionRules> bits{};
    visit_slots(block, PredictionRule::kButterfly, kEdgesOfASample,
                [&](Rows rows, std::size_t first, std::size_t count) {
                  for (int note = 0; note < count_notes(); ++note) {
                    const Prediction prediction = prediction_of(note);
                    rows.rule = prediction.rule;
                    recode_slot(block, rows, prediction.along_normals, numbers + first,
                                residuals + first, count, Recode::kEncode);
                    for (std::size_t i = first; i < first + count; ++i)
                      bits[static_cast<std::size_t>(note)] +=
                          static_cast<std::uint64_t>(std::bit_width(residuals[i]));
                  }
                });
    const auto end = bits.begin() + count_notes();
    return static_cast<int>(std::min_element(bits.begin(), end) - bits.begin());
  }
  Prediction noted_prediction(const FilterBlock& block) const {
    if (rule_ || block.note == nullptr) return {rule_.value_or(PredictionRule::kButterfly)};
    const int note = std::to_integer<int>(*block.note);
    if (note >= count_notes())
      throw Error(ErrorCode::kCorruption,
                  fmt::format("expected rule 0 to {}, found {}", count_notes() - 1, note));
    return prediction_of(note);
  }

  std::optional<PredictionRule> rule_;
  bool along_normals_;
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

/// RULE, step=STEP, RULE:step=STEP, or along.
HierarchyOptions options_of(std::string_view text) {
  HierarchyOptions options;
  if (text == "along") {
    options.along_normals = true;
    return options;
  }
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
                  "step=STEP, or one of the rules and :step=STEP, or along",
                  text_for_message(text)));
}

}  // namespace

std::unique_ptr<Filter> make_hierarchy_filter(std::string_view options, const FilterLevel& level) {
  const HierarchyOptions chosen = options_of(options);
  const AttributeSchema& schema = level.schema;
  if (chosen.along_normals && schema.components != 3)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("choose filter \"hierarchy:along\" for '{}': expected records of 3 "
                            "numbers, found {}",
                            schema.name, schema.components));
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
