#include "compressed/filters/lorenzo_filter.h"

#include <type_traits>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/predicting_filter.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Predictions are sums of integers, so decoding is a prefix sum along each row.
template <class Order>
struct LorenzoPredictor {
  static constexpr SlotRule kRule =
      std::is_same_v<Order, FloatOrder> ? SlotRule::kLorenzoFloat : SlotRule::kLorenzoInteger;

  template <int kBits, class Lanes>
  static Lanes form(const Lanes& bits) noexcept {
    return Order::template to<kBits>(bits);
  }
  template <int kBits, class Lanes>
  static Lanes bits(const Lanes& form) noexcept {
    return Order::template from<kBits>(form);
  }
  template <int kBits, class Lanes>
  static const Lanes& ordered(const Lanes& form) noexcept {
    return form;
  }
  template <int kBits, class Lanes>
  static const Lanes& from_ordered(const Lanes& ordered) noexcept {
    return ordered;
  }
  template <class Lanes>
  static const Lanes& along(const Lanes& l, const Lanes&) noexcept {
    return l;
  }
  template <class Lanes>
  static Lanes inside(const Lanes& l, const Lanes& a, const Lanes& b) noexcept {
    return static_cast<Lanes>(l + (a - b));
  }
};

struct NoEnvironment {
  NoEnvironment() {}  // so that an object is not an unused variable
};

template <class Word, class Order>
std::unique_ptr<Filter> make(const FilterLevel& level) {
  return std::make_unique<PredictingFilter<Word, LorenzoPredictor<Order>, NoEnvironment>>(level);
}

}  // namespace

std::unique_ptr<Filter> make_lorenzo_filter(std::string_view options, const FilterLevel& level) {
  refuse_options("lorenzo", options);
  const ComponentType type = level.schema.type;
  if (type == ComponentType::kFloat32) return make<std::uint32_t, FloatOrder>(level);
  if (type == ComponentType::kFloat64) return make<std::uint64_t, FloatOrder>(level);
  switch (component_bytes(type)) {
    case 1:
      return make<std::uint8_t, IntegerOrder>(level);
    case 2:
      return make<std::uint16_t, IntegerOrder>(level);
    case 4:
      return make<std::uint32_t, IntegerOrder>(level);
    default:
      return make<std::uint64_t, IntegerOrder>(level);
  }
}

PLAIT_END_NAMESPACE
