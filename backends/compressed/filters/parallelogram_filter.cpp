#include "compressed/filters/parallelogram_filter.h"

#include <fmt/format.h>

#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/predicting_filter.h"
#include "plait/default_arithmetic.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Numbers as vectors of floating-point lanes.
template <class Lanes>
auto numbers_of(const Lanes& bits) noexcept {
  if constexpr (std::is_same_v<Lanes, std::uint32_t>) {
    return __builtin_bit_cast(float, bits);
  } else if constexpr (std::is_same_v<Lanes, std::uint64_t>) {
    return __builtin_bit_cast(double, bits);
  } else {
    using Lane = std::conditional_t<sizeof(bits[0]) == 4, float, double>;
    typedef Lane Numbers __attribute__((vector_size(sizeof(Lanes))));
    return __builtin_bit_cast(Numbers, bits);
  }
}

/// Returns l + (a - b), or 0 if that is not a number: processors disagree about the bits of a
/// computed NaN. Every other result is defined by IEEE 754.
template <class Lanes>
Lanes continued(const Lanes& l, const Lanes& a, const Lanes& b) noexcept {
  const auto sum = numbers_of(l) + (numbers_of(a) - numbers_of(b));
  if constexpr (std::is_floating_point_v<decltype(sum)>)
    return sum == sum ? __builtin_bit_cast(Lanes, sum) : Lanes{0};
  else  // a comparison of vectors has all bits set where it is true
    return __builtin_bit_cast(Lanes, sum) & __builtin_bit_cast(Lanes, sum == sum);
}

struct ParallelogramPredictor {
  static constexpr SlotRule kRule = SlotRule::kParallelogram;

  template <int kBits, class Lanes>
  static const Lanes& form(const Lanes& bits) noexcept {
    return bits;
  }
  template <int kBits, class Lanes>
  static const Lanes& bits(const Lanes& form) noexcept {
    return form;
  }
  template <int kBits, class Lanes>
  static Lanes ordered(const Lanes& form) noexcept {
    return FloatOrder::to<kBits>(form);
  }
  template <int kBits, class Lanes>
  static Lanes from_ordered(const Lanes& ordered) noexcept {
    return FloatOrder::from<kBits>(ordered);
  }
  /// The next point of a straight line.
  template <class Lanes>
  static Lanes along(const Lanes& l, const Lanes& k) noexcept {
    return continued(l, l, k);
  }
  /// The fourth corner of a parallelogram.
  template <class Lanes>
  static Lanes inside(const Lanes& l, const Lanes& a, const Lanes& b) noexcept {
    return continued(l, a, b);
  }
};

}  // namespace

std::unique_ptr<Filter> make_parallelogram_filter(std::string_view options,
                                                  const FilterLevel& level) {
  refuse_options("parallelogram", options);
  const AttributeSchema& schema = level.schema;
  if (schema.type == ComponentType::kFloat32)
    return std::make_unique<
        PredictingFilter<std::uint32_t, ParallelogramPredictor, DefaultArithmetic>>(level);
  if (schema.type == ComponentType::kFloat64)
    return std::make_unique<
        PredictingFilter<std::uint64_t, ParallelogramPredictor, DefaultArithmetic>>(level);
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose filter parallelogram for attribute '{}': expected float32 or "
                          "float64, found {}; lorenzo predicts integers",
                          schema.name, to_string(schema.type)));
}

PLAIT_END_NAMESPACE
