#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "base/default_arithmetic.h"
#include "compressed/codecs/built_in_codecs.h"
#include "compressed/filters/built_in_filters.h"
#include "compressed/filters/column_rows.h"
#include "compressed/filters/ordered_words.h"
#include "compressed/filters/slot_rows.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

template <class Word>
using NumberOf = std::conditional_t<sizeof(Word) == 4, float, double>;

/// Returns a + (a - b), or 0 if that is not a number: processors disagree about the bits of a
/// computed NaN. Every other result is defined by IEEE 754.
template <class Word>
Word continued_line(Word a, Word b) noexcept {
  using Number = NumberOf<Word>;
  const Number number = __builtin_bit_cast(Number, a);
  const Number sum = number + (number - __builtin_bit_cast(Number, b));
  return sum == sum ? __builtin_bit_cast(Word, sum) : Word{0};
}

/// One component of the records of a slot: encodes or decodes it, number by number.
template <class Word, bool kEncodes>
class ComponentColumns {
  static constexpr int kBits = 8 * sizeof(Word);

 public:
  /// `from` and `to` are at the slot's first record.
  ComponentColumns(const SlotGrid& slot, std::size_t components, std::size_t component,
                   const std::byte* from, std::byte* to) noexcept
      : slot_(slot), components_(components), component_(component), from_(from), to_(to) {}

  /// The first record is predicted from `before`, the bits of the one in the slot before it. The
  /// others are predicted in integers, because adding floating-point numbers takes four times as
  /// long, and each has to wait for the one to its left. Returns the bits of the first record.
  Word first_row(Word before) noexcept {
    const Word first = put(0, 0, 0, FloatOrder::to<kBits>(before));
    Word l = FloatOrder::to<kBits>(first), step = 0;
    for (std::size_t column = 1; column < slot_.side; ++column) {
      const Word x = FloatOrder::to<kBits>(put(0, column, column, static_cast<Word>(l + step)));
      step = static_cast<Word>(x - l);
      l = x;
    }
    return first;
  }
  void other_rows() noexcept {
    std::size_t row_at = 0, above_at = 0, two_above_at = 0;
    for (std::size_t row = 1; row < slot_.side; ++row) {
      two_above_at = above_at;
      above_at = row_at;
      row_at += slot_.row_records(row - 1);
      for (std::size_t column = 0; column < slot_.row_records(row); ++column) {
        const Word a = number(above_at + column);
        const Word line = row == 1 ? a : continued_line(a, number(two_above_at + column));
        put(row, column, row_at + column, FloatOrder::to<kBits>(line));
      }
    }
  }

 private:
  const std::byte* numbers() const noexcept { return kEncodes ? from_ : to_; }
  Word number(std::size_t record) const noexcept {
    return read(numbers(), record * components_ + component_);
  }
  static Word read(const std::byte* from, std::size_t i) noexcept {
    Word word;
    std::memcpy(&word, from + i * sizeof word, sizeof word);
    return word;
  }
  /// Encodes or decodes the number of a record. Returns its bits.
  Word put(std::size_t row, std::size_t column, std::size_t record, Word prediction) noexcept {
    const std::size_t length = slot_.row_records(row);
    const std::size_t stored_at = (record - column) * components_ + component_ * length + column;
    const std::size_t number_at = record * components_ + component_;
    if constexpr (kEncodes) {
      const Word bits = read(from_, number_at);
      const Word word = zigzag<kBits>(static_cast<Word>(FloatOrder::to<kBits>(bits) - prediction));
      std::memcpy(to_ + stored_at * sizeof word, &word, sizeof word);
      return bits;
    } else {
      const Word bits = FloatOrder::from<kBits>(
          static_cast<Word>(prediction + from_zigzag<kBits>(read(from_, stored_at))));
      std::memcpy(to_ + number_at * sizeof bits, &bits, sizeof bits);
      return bits;
    }
  }

  const SlotGrid& slot_;
  std::size_t components_, component_;
  const std::byte* from_;
  std::byte* to_;
};

template <class Word>
class ColumnsFilter final : public Filter {
 public:
  explicit ColumnsFilter(const FilterLevel& level)
      : geometry_(level.geometry), components_(level.schema.components) {}

  std::size_t scratch_bytes() const noexcept override { return components_ * sizeof(Word); }
  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const DefaultArithmetic arithmetic;
    run<true>(block, raw.data(), filtered.data());
  }
  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const DefaultArithmetic arithmetic;
    run<false>(block, filtered.data(), raw.data());
  }

 private:
  /// Not inlined, so that no computation is moved out of the arithmetic's scope.
  template <bool kEncodes>
  [[gnu::noinline]] void run(const FilterBlock& block, const std::byte* from,
                             std::byte* to) const noexcept {
    auto* const before = reinterpret_cast<Word*>(block.scratch.data());
    std::fill_n(before, components_, Word{0});
    for_each_slot(*geometry_, block.block, [&](const SlotGrid& slot) {
      const std::size_t at = slot.first * components_ * sizeof(Word);
      if (const ColumnSlot whole{slot.side, static_cast<int>(components_)};
          sizeof(Word) == 4 && !slot.half && has_column_rows(whole))
        return vectors<kEncodes>(whole, from + at, to + at, before);
      for (std::size_t i = 0; i < components_; ++i) {
        ComponentColumns<Word, kEncodes> columns(slot, components_, i, from + at, to + at);
        before[i] = columns.first_row(before[i]);
        columns.other_rows();
      }
    });
  }

  template <bool kEncodes>
  static void vectors(const ColumnSlot& slot, const std::byte* from, std::byte* to,
                      Word* before) noexcept {
    if constexpr (sizeof(Word) == 4 && kEncodes)
      encode_column_rows(slot, reinterpret_cast<const float*>(from), reinterpret_cast<Word*>(to),
                         before);
    else if constexpr (sizeof(Word) == 4)
      decode_column_rows(slot, reinterpret_cast<const Word*>(from), reinterpret_cast<float*>(to),
                         before);
  }

  const LevelGeometry* geometry_;
  std::size_t components_;
};

}  // namespace

std::unique_ptr<Filter> make_columns_filter(std::string_view options, const FilterLevel& level) {
  refuse_options("columns", options);
  const AttributeSchema& schema = level.schema;
  if (schema.type == ComponentType::kFloat32)
    return std::make_unique<ColumnsFilter<std::uint32_t>>(level);
  if (schema.type == ComponentType::kFloat64)
    return std::make_unique<ColumnsFilter<std::uint64_t>>(level);
  throw Error(ErrorCode::kNotSupported,
              fmt::format("choose filter columns for attribute '{}': expected float32 or float64, "
                          "found {}; shuffle takes integers",
                          schema.name, to_string(schema.type)));
}

PLAIT_END_NAMESPACE
