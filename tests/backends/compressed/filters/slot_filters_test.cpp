// The filter columns: its bytes are those of docs/filters/columns.md, it gives every bit pattern
// back, and any bytes decode.
#include <fmt/format.h>

#include <bit>
#include <catch2/catch.hpp>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "compressed/filters/built_in_filters.h"
#include "plait/error.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/pipeline_registry.h"
#include "plait/registry.h"
#include "rows/every_target.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;

const ComponentType kAllTypes[] = {
    ComponentType::kFloat32, ComponentType::kFloat64, ComponentType::kInt8,  ComponentType::kInt16,
    ComponentType::kInt32,   ComponentType::kInt64,   ComponentType::kUint8, ComponentType::kUint16,
    ComponentType::kUint32,  ComponentType::kUint64};

/// A level whose edges have these shapes, again and again.
struct Level {
  LevelGeometry geometry;
  FilterLevel filter_level;
  std::vector<SlotShape> shapes;

  Level(const std::string& pattern, std::uint64_t edges, int refinements, AttributeSchema schema,
        std::uint64_t block_bytes = 1 << 16) {
    std::vector<EdgeId> half, absent;
    for (EdgeId edge = 0; edge < edges; ++edge) {
      const char shape = pattern[edge % pattern.size()];
      if (shape == 'h') half.push_back(edge);
      if (shape == '-') absent.push_back(edge);
      shapes.push_back(shape == 'h'   ? SlotShape::kHalf
                       : shape == '-' ? SlotShape::kAbsent
                                      : SlotShape::kWhole);
    }
    geometry = LevelGeometry({edges, EdgeSet(half), EdgeSet(absent)},
                             BaseRelativeLevel(refinements), schema.record_bytes(), block_bytes);
    filter_level.schema = schema;
    filter_level.geometry = &geometry;
    filter_level.level = refinements;
  }
  Level(const Level&) = delete;
  Level& operator=(const Level&) = delete;

  std::unique_ptr<Filter> make() const {
    return std::move(default_pipelines().open("columns,none", filter_level).filters.at(0));
  }
};

Bytes encode(const Filter& filter, std::uint64_t block, const Bytes& raw) {
  Bytes filtered(raw.size(), std::byte{0xcc}), scratch(filter.scratch_bytes());
  filter.encode({.block = block, .scratch = scratch}, raw, filtered);
  return filtered;
}
Bytes decode(const Filter& filter, std::uint64_t block, const Bytes& filtered) {
  Bytes raw(filtered.size(), std::byte{0xcc}), scratch(filter.scratch_bytes());
  filter.decode({.block = block, .scratch = scratch}, filtered, raw);
  return raw;
}

// The definition, number by number, as docs/filters/columns.md has it.

using Wide = unsigned __int128;

/// The integer of a number with these bits, so that integers are in the order of the numbers.
Wide order(std::uint64_t bits, ComponentType type) {
  const Wide sign = Wide{1} << (8 * component_bytes(type) - 1);
  return bits & sign ? sign - 1 - (bits - sign) : sign + bits;
}

template <class Real, class Bits>
std::uint64_t continued(std::uint64_t a, std::uint64_t b) {
  const auto number = [](std::uint64_t bits) {
    return std::bit_cast<Real>(static_cast<Bits>(bits));
  };
  const volatile Real step = number(a) - number(b);
  const volatile Real sum = number(a) + step;
  return std::isnan(sum) ? 0 : std::bit_cast<Bits>(static_cast<Real>(sum));
}

class Definition {
 public:
  explicit Definition(const Level& level)
      : level_(level),
        type_(level.filter_level.schema.type),
        width_(component_bytes(type_)),
        components_(level.filter_level.schema.components) {}

  Bytes encode(std::uint64_t block, const Bytes& raw) {
    raw_ = &raw;
    Bytes filtered(raw.size());
    const auto n = std::size_t{1} << (level_.geometry.level().refinements - 1);
    std::size_t start = 0;
    std::optional<std::size_t> slot_before;
    for (EdgeId edge = level_.geometry.first_edge(block); edge < level_.geometry.edge_after(block);
         ++edge) {
      const SlotShape shape = level_.shapes[edge];
      if (shape == SlotShape::kAbsent) continue;
      const auto place = [&, half = shape == SlotShape::kHalf](std::size_t r, std::size_t c) {
        return start + (half ? r * n - r * (r - 1) / 2 + c : r * n + c);
      };
      for (std::size_t r = 0; r < n; ++r)
        for (std::size_t c = 0; c < (shape == SlotShape::kHalf ? n - r : n); ++c)
          for (std::size_t i = 0; i < components_; ++i) {
            const auto bits = [&](std::size_t row, std::size_t column) {
              return read(place(row, column), i);
            };
            Wide predicted;
            if (r == 0 && c == 0)
              predicted = order(slot_before ? read(*slot_before, i) : 0, type_);
            else if (r == 0)
              predicted = c == 1 ? order(bits(0, 0), type_)
                                 : 2 * order(bits(0, c - 1), type_) - order(bits(0, c - 2), type_);
            else if (r == 1)
              predicted = order(bits(0, c), type_);
            else
              predicted = line(bits(r - 1, c), bits(r - 2, c));
            const std::size_t length = shape == SlotShape::kHalf ? n - r : n;
            const std::size_t word = place(r, 0) * components_ + i * length + c;
            write(filtered, word, order(bits(r, c), type_) - predicted);
          }
      slot_before = start;
      start = place(n, 0);
      if (shape == SlotShape::kHalf) start = *slot_before + n * (n + 1) / 2;
    }
    CHECK(start * width_ * components_ == raw.size());
    return filtered;
  }

 private:
  std::uint64_t read(std::size_t record, std::size_t component) const {
    std::uint64_t bits = 0;
    std::memcpy(&bits, raw_->data() + (record * components_ + component) * width_, width_);
    return bits;
  }
  void write(Bytes& to, std::size_t word, Wide difference) const {
    const int bits = static_cast<int>(8 * width_);
    const Wide all = (Wide{1} << bits) - 1;
    difference &= all;
    const bool negative = (difference >> (bits - 1)) != 0;
    // 0, -1, 1, -2 become 0, 1, 2, 3.
    const auto number = static_cast<std::uint64_t>(negative ? 2 * ((all + 1 - difference) & all) - 1
                                                            : 2 * difference);
    std::memcpy(to.data() + word * width_, &number, width_);
  }
  Wide line(std::uint64_t a, std::uint64_t b) const {
    return order(width_ == 4 ? continued<float, std::uint32_t>(a, b)
                             : continued<double, std::uint64_t>(a, b),
                 type_);
  }

  const Level& level_;
  ComponentType type_;
  std::size_t width_, components_;
  const Bytes* raw_ = nullptr;
};

enum class Kind { kRandom, kSmooth, kSpecial };

/// Bytes of a block: any bits, a wave, or numbers that arithmetic treats in their own way.
Bytes content(std::size_t size, ComponentType type, Kind kind, unsigned seed) {
  std::mt19937_64 random(seed);
  Bytes bytes(size);
  const std::size_t width = component_bytes(type);
  for (std::size_t at = 0; at + width <= size; at += width) {
    std::uint64_t bits = random();
    const double wave = 3 + std::sin(0.01 * double(at)) + 1e-6 * double(random() % 16);
    if (kind == Kind::kSmooth)
      bits = type == ComponentType::kFloat32 ? std::bit_cast<std::uint32_t>(float(wave))
                                             : std::bit_cast<std::uint64_t>(wave);
    if (kind == Kind::kSpecial && type == ComponentType::kFloat32) {
      constexpr std::uint32_t values[] = {
          0,          0x80000000, 0x7f800000, 0xff800000, 0x7fc00000, 0xffc00000, 0x7f800001,
          0xffffffff, 0x00000001, 0x80000001, 0x007fffff, 0x00800000, 0x7f7fffff, 0xff7fffff,
          0x3f800000, 0xbf800000, 0x7fbfffff, 0x00ffffff, 0x7fd12345};
      bits = values[random() % std::size(values)];
    }
    if (kind == Kind::kSpecial && type == ComponentType::kFloat64) {
      constexpr std::uint64_t values[] = {0,
                                          0x8000000000000000,
                                          0x7ff0000000000000,
                                          0xfff0000000000000,
                                          0x7ff8000000000000,
                                          0x7ff0000000000001,
                                          0xffffffffffffffff,
                                          0x0000000000000001,
                                          0x000fffffffffffff,
                                          0x7fefffffffffffff,
                                          0x3ff0000000000000};
      bits = values[random() % std::size(values)];
    }
    std::memcpy(bytes.data() + at, &bits, width);
  }
  return bytes;
}

std::size_t first_difference_of_slots(const Bytes& a, const Bytes& b) {
  std::size_t count = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

void check_level(const Level& level) {
  const auto filter = level.make();
  Definition definition(level);
  const ComponentType type = level.filter_level.schema.type;
  for (std::uint64_t block = 0; block < level.geometry.block_count(); ++block)
    for (const Kind kind : {Kind::kRandom, Kind::kSmooth, Kind::kSpecial}) {
      const Bytes raw = content(level.geometry.block_bytes(block), type, kind, unsigned(block) + 7);
      const Bytes filtered = encode(*filter, block, raw);
      CAPTURE(block, int(kind));
      CHECK(first_difference_of_slots(filtered, definition.encode(block, raw)) == 0);
      CHECK(first_difference_of_slots(decode(*filter, block, filtered), raw) == 0);
      // Any bytes decode, and a block has one encoding only.
      const Bytes decoded = decode(*filter, block, raw);
      CHECK(first_difference_of_slots(encode(*filter, block, decoded), raw) == 0);
    }
}

}  // namespace

TEST_CASE("Columns_EveryShapeTypeAndRecord_AreTheDefinitionAndInverse") {
  for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kFloat64})
    for (const std::uint32_t components : {1u, 2u, 3u, 4u, 5u, 9u})
      for (const char* pattern : {"w", "h", "wh", "wwwwwh", "w-wwhw-", "-h", "wwwwwww-hh"})
        for (int refinements = 1; refinements <= 4; ++refinements) {
          CAPTURE(to_string(type), components, pattern, refinements);
          check_level(Level(pattern, 23, refinements, {"x", type, components}, 1 << 12));
        }
}

TEST_CASE("Columns_LargeSlots_AreTheDefinitionAndInverse") {
  for (const int refinements : {5, 7}) {
    CAPTURE(refinements);
    check_level(Level("wwwwwhw", 14, refinements, {"x", ComponentType::kFloat32, 3}));
    check_level(Level("whw", 5, refinements, {"x", ComponentType::kFloat64, 3}));
  }
}

TEST_CASE("Columns_OnEveryInstructionSet_AreTheDefinitionAndInverse") {
  fused_rows::on_every_target([](const char* target) {
    for (const std::uint32_t components : {1u, 2u, 3u, 4u})
      for (const int refinements : {1, 2, 3, 4, 5, 6}) {
        CAPTURE(target, components, refinements);
        check_level(
            Level("wwwwwwwwh", 41, refinements, {"x", ComponentType::kFloat32, components}));
      }
  });
}

TEST_CASE("Columns_LevelWithoutSlots_HasNothingToFilter") {
  const Level level("-", 5, 3, {"x", ComponentType::kFloat32, 3});
  CHECK(level.geometry.total_bytes() == 0);
  for (std::uint64_t block = 0; block < level.geometry.block_count(); ++block)
    CHECK(encode(*level.make(), block, {}).empty());
}

namespace {

/// How many words are not 0 from the third row of each slot on: the first two begin the lines. The
/// level has 4 slots of 8 x 8 numbers; `value` gives them by slot, row and column.
template <class Value>
int words_inside(const std::string& filters, Value value) {
  const Level level("w", 4, 4, {"x", ComponentType::kFloat32, 1});
  Bytes bytes(level.geometry.block_bytes(0));
  for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
    const float number = value(int(i / 64), int(i / 8 % 8), int(i % 8));
    std::memcpy(bytes.data() + 4 * i, &number, 4);
  }
  for (const auto& filter : default_pipelines().open(filters + ",none", level.filter_level).filters)
    bytes = encode(*filter, 0, bytes);
  int found = 0;
  for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
    std::uint32_t word;
    std::memcpy(&word, bytes.data() + 4 * i, 4);
    found += i / 8 % 8 > 1 && word != 0;
  }
  return found;
}

}  // namespace

TEST_CASE("Columns_APlane_LeavesNothingInsideASlot") {
  CHECK(words_inside("columns", [](int slot, int row, int column) {
          return float(slot) + 0.25f * float(row) - 0.5f * float(column);
        }) == 0);
}

TEST_CASE("Lattice_AnyBits_ComeBack") {
  const auto check = [](auto number) {
    using Number = decltype(number);
    using Limits = std::numeric_limits<Number>;
    std::vector<Number> numbers = {
        Number(0),          -Number(0),          Limits::denorm_min(), -Limits::denorm_min(),
        Limits::min() / 2,  -Limits::min() / 3,  Limits::max(),        Limits::lowest(),
        Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),  Number(0.1)};
    std::mt19937_64 random(21);
    while (numbers.size() < 3000) {
      using Word = std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>;
      numbers.push_back(std::bit_cast<Number>(static_cast<Word>(random())));
    }
    const FilterLevel level{.schema = {.type = sizeof(Number) == 4 ? ComponentType::kFloat32
                                                                   : ComponentType::kFloat64}};
    for (const char* step : {"0.001", "1e-30", "4"}) {
      CAPTURE(step, sizeof(Number));
      const auto filter = make_lattice_filter(step, level);
      const auto raw = std::as_bytes(std::span(numbers));
      std::vector<std::byte> words(raw.size()), back(raw.size());
      filter->encode({}, raw, words);
      filter->decode({}, words, back);
      CHECK(std::ranges::equal(back, raw));
    }
  };
  check(float{});
  check(double{});
}

TEST_CASE("Columns_AfterALattice_ContinueLinesOfStepsExactly") {
  // The floats nearest to multiples of the step lie on no straight line; the multiples do.
  for (const int sign : {1, -1}) {
    const auto steps = [sign](int slot, int row, int column) {
      return static_cast<float>(0.001 * sign *
                                (1000 * (1 + slot) + 37 * row + 11 * column * column));
    };
    CHECK(words_inside("columns", steps) > 50);
    CHECK(words_inside("lattice:0.001+columns", steps) == 0);
  }
}

TEST_CASE("Columns_AFewNumbers_HaveTheBytesOfThePage") {
  const Level level("w", 1, 2, {"x", ComponentType::kFloat32, 2});
  // Two rows of two records of two components. The words of a row are grouped by component.
  const float numbers[] = {1, -1, 1.5, -1, 2, std::nextafterf(-1, 0), 1.5, -1.5};
  const std::uint32_t expected[] = {0x7f000000, 0x00800000, 0x7f000001, 0,
                                    0x01000000, 0,          2,          0x007fffff};
  Bytes raw(sizeof(numbers));
  std::memcpy(raw.data(), numbers, sizeof(numbers));
  const Bytes filtered = encode(*level.make(), 0, raw);
  std::uint32_t found[8];
  std::memcpy(found, filtered.data(), sizeof found);
  for (int i = 0; i < 8; ++i) {
    CAPTURE(i, found[i], expected[i]);
    CHECK(found[i] == expected[i]);
  }
}

TEST_CASE("Columns_UnderOtherRounding_HaveTheSameBytes") {
  const Level level("wh", 8, 4, {"x", ComponentType::kFloat32, 3});
  const auto filter = level.make();
  const Bytes raw =
      content(level.geometry.block_bytes(0), ComponentType::kFloat32, Kind::kSmooth, 3);
  const Bytes small =
      content(level.geometry.block_bytes(0), ComponentType::kFloat32, Kind::kSpecial, 4);
  for (const Bytes& block : {raw, small}) {
    const Bytes expected = encode(*filter, 0, block);
    for (const int rounding : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
      std::fesetround(rounding);
      const Bytes found = encode(*filter, 0, block), back = decode(*filter, 0, expected);
      const int after = std::fegetround();
      std::fesetround(FE_TONEAREST);
      CHECK(after == rounding);
      CHECK(first_difference_of_slots(found, expected) == 0);
      CHECK(first_difference_of_slots(back, block) == 0);
    }
#if defined(__x86_64__)
    const unsigned before = __builtin_ia32_stmxcsr();
    __builtin_ia32_ldmxcsr(before | 0x8040);  // subnormal numbers count as zero
    const Bytes found = encode(*filter, 0, block), back = decode(*filter, 0, expected);
    __builtin_ia32_ldmxcsr(before);
    CHECK(first_difference_of_slots(found, expected) == 0);
    CHECK(first_difference_of_slots(back, block) == 0);
#endif
  }
}

TEST_CASE("Columns_OfIntegers_AreRefusedInWords") {
  for (const ComponentType type : kAllTypes) {
    const FilterLevel level{.schema = {"colour", type, 4}};
    if (type == ComponentType::kFloat32 || type == ComponentType::kFloat64) {
      CHECK_NOTHROW(default_pipelines().open("columns+shuffle,zstd:1", level));
      continue;
    }
    try {
      default_pipelines().open("columns,zstd:1", level);
      FAIL("accepted");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kNotSupported);
      CHECK_THAT(error.what(), Catch::Contains("'colour'") && Catch::Contains("shuffle"));
    }
  }
}

TEST_CASE("Columns_TakesNoOptions") {
  CHECK_THROWS_AS(default_pipelines().open("columns:2,none", {}), Error);
}

}  // namespace plait::test
