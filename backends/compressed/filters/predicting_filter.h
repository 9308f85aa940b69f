// backends/compressed/filters/predicting_filter.h: what filters share that predict each record of a
// slot from records of the slot before it, and store the difference.
//
// A slot is a grid. In the pictures, x is the record that is predicted.
//
//   inside        b a    (the row before)
//                 l x    is predicted from l, a and b     (`inside`)
//   first row     k l x  from l, and from k if there is one       (`along`)
//   first column         the same, with the two records above
//   first record         equals the first record of the slot before it in the block; in the first
//                        slot all bits of the prediction are 0
//
// The stored word is zigzag(m(x) - m(prediction)), modulo 2^32 or 2^64, where m maps the bits of a
// number to an integer of the same order (ordered_words.h). So decoding inverts encoding for every
// bit pattern, whatever the prediction is.
//
// Decoding a record has to wait for the one to its left. So several slots are decoded at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "compressed/filters/ordered_words.h"
#include "compressed/filters/slot_rows.h"
#include "compressed/filters/wide_slots.h"
#include "plait/backends/pipeline.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// How many slots are decoded at once, of records that decode_wide_slots() does not take.
constexpr std::size_t kSlotsAtOnce = 4;

/// `kLanes` words as a vector, so that the components of a record are computed together. The
/// vectors are GCC's, and 16 bytes at most: every instruction set has those, and they hold a
/// record, so there is nothing to dispatch. A vector of three words has a fourth lane that is not
/// used.
template <class Word, int kLanes>
struct LanesOf {
  typedef Word Type __attribute__((vector_size((kLanes == 3 ? 4 : kLanes) * sizeof(Word))));
};
template <class Word>
struct LanesOf<Word, 1> {
  using Type = Word;
};

/// The loops, for `kLanes` components of a record. `Predictor` has static functions:
///   Form form<kBits>(Lanes bits), Lanes bits<kBits>(Form)       what predictions are computed from
///   Form from_ordered<kBits>(Lanes), Lanes ordered<kBits>(Form)
///   Form along(Form l, Form k), Form inside(Form l, Form a, Form b)
/// and kRule, the same as a rule of wide_slots.h.
template <class Word, int kLanes, class Predictor>
class SlotPrediction {
  using Lanes = typename LanesOf<Word, kLanes>::Type;
  static constexpr int kBits = 8 * sizeof(Word);
  static constexpr std::size_t kBytes = kLanes * sizeof(Word);

 public:
  /// `stride`: from one record to the next, in bytes.
  SlotPrediction(const LevelGeometry& geometry, std::size_t stride)
      : geometry_(geometry), stride_(stride) {}

  void encode(std::uint64_t block, const std::byte* raw, std::byte* filtered) const noexcept {
    Lanes previous{};
    for_each_slot(geometry_, block, [&](const SlotGrid& slot) {
      const std::byte* const from = raw + slot.first * stride_;
      std::byte* const to = filtered + slot.first * stride_;
      const Lanes first = load<true>(from);
      put<true>(to, form(first), form(previous));
      previous = first;
      encode_slot(slot, from, to);
    });
  }

  /// `row` has kMostWideSlots records of 16 bytes for each column of a slot.
  void decode(std::uint64_t block, const std::byte* filtered, std::byte* raw,
              std::byte* row) const noexcept {
    // The first records come first, because each needs the one of the slot before.
    Lanes previous{};
    for_each_slot(geometry_, block, [&](const SlotGrid& slot) {
      const auto x = take(load<true>(filtered + slot.first * stride_), form(previous));
      previous = bits(x);
      store<true>(previous, raw + slot.first * stride_);
    });
    std::array<const std::byte*, kMostWideSlots> from;
    std::array<std::byte*, kMostWideSlots> to;
    const std::size_t wide = sizeof(Word) == 4 && kLanes >= 3 ? wide_slots_at_once() : 0;
    const std::size_t at_once = wide > 0 ? wide : kSlotsAtOnce;
    std::size_t waiting = 0;
    std::size_t side = 0;
    for_each_slot(geometry_, block, [&](const SlotGrid& slot) {
      from[waiting] = filtered + slot.first * stride_;
      to[waiting] = raw + slot.first * stride_;
      if (slot.half) return decode_slots<1>(slot.side, true, &from[waiting], &to[waiting], row);
      side = slot.side;
      if (++waiting < at_once) return;
      if (wide > 0)
        decode_wide_slots(Predictor::kRule, {from.data(), to.data(), side, stride_, kLanes, row});
      else
        decode_slots<kSlotsAtOnce>(side, false, from.data(), to.data(), row);
      waiting = 0;
    });
    std::size_t i = 0;
    for (; i + kSlotsAtOnce <= waiting; i += kSlotsAtOnce)
      decode_slots<kSlotsAtOnce>(side, false, &from[i], &to[i], row);
    for (; i < waiting; ++i) decode_slots<1>(side, false, &from[i], &to[i], row);
  }

 private:
  using Form = std::remove_cvref_t<decltype(Predictor::template form<kBits>(Lanes{}))>;

  // If a record's vector has a lane more than the record, loading and storing it touches the next
  // record too. kExactly avoids that, for records that nothing follows.
  template <bool kExactly>
  static Lanes load(const std::byte* from) noexcept {
    Lanes lanes{};
    std::memcpy(&lanes, from, kExactly ? kBytes : sizeof(Lanes));
    return lanes;
  }
  template <bool kExactly>
  static void store(const Lanes& lanes, std::byte* to) noexcept {
    std::memcpy(to, &lanes, kExactly ? kBytes : sizeof(Lanes));
  }
  static Form form(const Lanes& bits) noexcept { return Predictor::template form<kBits>(bits); }
  static Lanes bits(const Form& form) noexcept { return Predictor::template bits<kBits>(form); }

  template <bool kExactly>
  static void put(std::byte* to, const Form& x, const Form& prediction) noexcept {
    const Lanes difference = static_cast<Lanes>(Predictor::template ordered<kBits>(x) -
                                                Predictor::template ordered<kBits>(prediction));
    store<kExactly>(zigzag<kBits>(difference), to);
  }
  static Form take(const Lanes& stored, const Form& prediction) noexcept {
    return Predictor::template from_ordered<kBits>(static_cast<Lanes>(
        Predictor::template ordered<kBits>(prediction) + from_zigzag<kBits>(stored)));
  }

  void encode_slot(const SlotGrid& slot, const std::byte* from, std::byte* to) const noexcept {
    Form k{}, l = form(load<true>(from));
    for_each_column(slot.row_records(0), [&](std::size_t at, std::size_t column, auto exactly) {
      const Form x = form(load<exactly.value>(from + at));
      put<exactly.value>(to + at, x, column == 1 ? l : Predictor::along(l, k));
      k = l;
      l = x;
    });
    const std::byte* above = from;
    for (std::size_t row = 1; row < slot.side; ++row) {
      const std::byte* const two_above = above;
      above = from;
      from += slot.row_records(row - 1) * stride_;
      to += slot.row_records(row - 1) * stride_;
      Form b = form(load<true>(above));
      l = form(load<true>(from));
      put<true>(to, l, row == 1 ? b : Predictor::along(b, form(load<true>(two_above))));
      for_each_column(slot.row_records(row), [&](std::size_t at, std::size_t, auto exactly) {
        const Form a = form(load<exactly.value>(above + at));
        const Form x = form(load<exactly.value>(from + at));
        put<exactly.value>(to + at, x, Predictor::inside(l, a, b));
        l = x;
        b = a;
      });
    }
  }

  /// Slots of one shape, whose first records are decoded. The row above is also kept in `kept`,
  /// each record as a whole vector: the processor cannot load a vector that two stores have just
  /// written.
  template <std::size_t kSlots>
  void decode_slots(std::size_t side, bool half, const std::byte* const* first_from,
                    std::byte* const* first_to, std::byte* kept) const noexcept {
    const SlotGrid shape{0, side, half};
    const std::byte* from[kSlots];
    std::byte* to[kSlots];
    Form l[kSlots], b[kSlots] = {}, first[kSlots], above_first[kSlots] = {};
    for (std::size_t s = 0; s < kSlots; ++s) {
      from[s] = first_from[s];
      to[s] = first_to[s];
      first[s] = form(load<true>(to[s]));
      l[s] = first[s];
      keep(kept, s, l[s]);
    }
    for_each_column(shape.row_records(0), [&](std::size_t at, std::size_t column, auto exactly) {
      for (std::size_t s = 0; s < kSlots; ++s) {
        const Form k = b[s];
        b[s] = l[s];
        l[s] =
            take(load<exactly.value>(from[s] + at), column == 1 ? l[s] : Predictor::along(l[s], k));
        store<exactly.value>(bits(l[s]), to[s] + at);
        keep(kept, column * kSlots + s, l[s]);
      }
    });
    for (std::size_t row = 1; row < side; ++row) {
      const std::size_t before = shape.row_records(row - 1) * stride_;
      for (std::size_t s = 0; s < kSlots; ++s) {
        from[s] += before;
        to[s] += before;
        b[s] = first[s];
        l[s] = take(load<true>(from[s]), row == 1 ? b[s] : Predictor::along(b[s], above_first[s]));
        above_first[s] = b[s];
        first[s] = l[s];
        store<true>(bits(l[s]), to[s]);
      }
      for_each_column(
          shape.row_records(row), [&](std::size_t at, std::size_t column, auto exactly) {
            for (std::size_t s = 0; s < kSlots; ++s) {
              const Form a = kept_at(kept, column * kSlots + s);
              l[s] = take(load<exactly.value>(from[s] + at), Predictor::inside(l[s], a, b[s]));
              store<exactly.value>(bits(l[s]), to[s] + at);
              keep(kept, column * kSlots + s, l[s]);
              b[s] = a;
            }
          });
    }
  }

  /// Calls visit(offset, column, exactly) for the records of a row but the first. The last one is
  /// exact, because the next row is not written yet.
  template <class Visit>
  void for_each_column(std::size_t records, Visit visit) const noexcept {
    std::size_t at = stride_, column = 1;
    for (; column + 1 < records; at += stride_, ++column) visit(at, column, std::false_type());
    if (column < records) visit(at, column, std::true_type());
  }

  static void keep(std::byte* kept, std::size_t i, const Form& form) noexcept {
    std::memcpy(kept + i * sizeof(Form), &form, sizeof(Form));
  }
  static Form kept_at(const std::byte* kept, std::size_t i) noexcept {
    Form form;
    std::memcpy(&form, kept + i * sizeof(Form), sizeof(Form));
    return form;
  }

  const LevelGeometry& geometry_;
  std::size_t stride_;
};

/// The filter. `Environment` is an object that exists while records are computed.
template <class Word, class Predictor, class Environment>
class PredictingFilter final : public Filter {
 public:
  explicit PredictingFilter(const FilterLevel& level)
      : geometry_(level.geometry), components_(level.schema.components) {}

  std::size_t scratch_bytes() const noexcept override {
    if (geometry_ == nullptr) return 0;
    constexpr std::size_t kColumnBytes = 16 * kMostWideSlots;
    return static_cast<std::size_t>(slot_side(geometry_->level().refinements)) * kColumnBytes;
  }
  void encode(const FilterBlock& block, std::span<const std::byte> raw,
              std::span<std::byte> filtered) const override {
    const Environment environment;
    run<true>(block, raw.data(), filtered.data());
  }
  void decode(const FilterBlock& block, std::span<const std::byte> filtered,
              std::span<std::byte> raw) const override {
    const Environment environment;
    run<false>(block, filtered.data(), raw.data());
  }

 private:
  /// Not inlined, so that no computation is moved out of the environment.
  template <bool kEncodes>
  [[gnu::noinline]] void run(const FilterBlock& block, const std::byte* from,
                             std::byte* to) const noexcept {
    if constexpr (sizeof(Word) == 4) {
      if (components_ == 3) return run_lanes<3, kEncodes>(block, from, to);
      if (components_ == 4) return run_lanes<4, kEncodes>(block, from, to);
    }
    if constexpr (sizeof(Word) >= 4)
      if (components_ == 2) return run_lanes<2, kEncodes>(block, from, to);
    for (std::size_t i = 0; i < components_; ++i)
      run_lanes<1, kEncodes>(block, from + i * sizeof(Word), to + i * sizeof(Word));
  }
  template <int kLanes, bool kEncodes>
  void run_lanes(const FilterBlock& block, const std::byte* from, std::byte* to) const noexcept {
    const SlotPrediction<Word, kLanes, Predictor> prediction(*geometry_,
                                                             components_ * sizeof(Word));
    kEncodes ? prediction.encode(block.block, from, to)
             : prediction.decode(block.block, from, to, block.scratch.data());
  }

  const LevelGeometry* geometry_;
  std::size_t components_;
};

PLAIT_END_NAMESPACE
