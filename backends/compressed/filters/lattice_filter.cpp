#include <fmt/format.h>

#include <charconv>

#include "base/default_arithmetic.h"
#include "base/text.h"
#include "compressed/filters/built_in_filters.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Number>
class LatticeFilter final : public Filter {
  using Lattice = NumberLattice<Number>;
  using Word = typename Lattice::Word;

 public:
  explicit LatticeFilter(double step) : lattice_(step) {}

  void encode(const FilterBlock&, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const DefaultArithmetic arithmetic;
    to_words(raw, filtered);
  }
  void decode(const FilterBlock&, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const DefaultArithmetic arithmetic;
    to_numbers(filtered, raw);
  }

 private:
  // Not inlined, so that no computation is moved out of the arithmetic.
  [[gnu::noinline]] void to_words(std::span<const std::byte> raw,
                                  std::span<std::byte> filtered) const noexcept {
    const auto* __restrict const from = reinterpret_cast<const Number*>(raw.data());
    auto* __restrict const to = reinterpret_cast<Word*>(filtered.data());
    for (std::size_t i = 0; i < raw.size() / sizeof(Number); ++i)
      to[i] = Lattice::from_ordered(lattice_.word(from[i]));
  }
  [[gnu::noinline]] void to_numbers(std::span<const std::byte> filtered,
                                    std::span<std::byte> raw) const noexcept {
    const auto* __restrict const from = reinterpret_cast<const Word*>(filtered.data());
    auto* __restrict const to = reinterpret_cast<Number*>(raw.data());
    for (std::size_t i = 0; i < raw.size() / sizeof(Number); ++i)
      to[i] = lattice_.number_of_word(Lattice::ordered(from[i]));
  }

  Lattice lattice_;
};

}  // namespace

double step_from_text(std::string_view filter, std::string_view text) {
  double step = 0;
  const char* const end = text.data() + text.size();
  const auto [after, error] = std::from_chars(text.data(), end, step);
  if (error != std::errc() || after != end || !(step >= kLeastStep && step <= kMostStep))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("choose filter \"{}\": expected a step from {:g} to {:g}, found "
                            "\"{}\"",
                            filter, kLeastStep, kMostStep, text_for_message(text)));
  return step;
}

std::unique_ptr<Filter> make_lattice_filter(std::string_view options, const FilterLevel& level) {
  const double step = step_from_text("lattice", options);
  const AttributeSchema& schema = level.schema;
  if (schema.type == ComponentType::kFloat32) return std::make_unique<LatticeFilter<float>>(step);
  if (schema.type == ComponentType::kFloat64) return std::make_unique<LatticeFilter<double>>(step);
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose filter \"lattice\" for '{}': expected float32 or float64, found "
                          "{}",
                          schema.name, to_string(schema.type)));
}

PLAIT_END_NAMESPACE
