// The filters lorenzo, parallelogram and columns: their bytes are those of docs/filters/, they give
// every bit pattern back, and any bytes decode.
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

#include "plait/backends/pipeline.h"
#include "plait/error.h"
#include "plait/level_geometry.h"
#include "rows/every_target.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;

const ComponentType kAllTypes[] = {
    ComponentType::kFloat32, ComponentType::kFloat64, ComponentType::kInt8,  ComponentType::kInt16,
    ComponentType::kInt32,   ComponentType::kInt64,   ComponentType::kUint8, ComponentType::kUint16,
    ComponentType::kUint32,  ComponentType::kUint64};

bool is_real(ComponentType type) {
  return type == ComponentType::kFloat32 || type == ComponentType::kFloat64;
}

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

  std::unique_ptr<Filter> make(const std::string& filter) const {
    return std::move(default_pipelines().make(filter + ",none", filter_level).filters.at(0));
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

// The definition, number by number, as docs/filters/ has it.

using Wide = unsigned __int128;

/// The integer of a number with these bits, so that integers are in the order of the numbers.
Wide order(std::uint64_t bits, ComponentType type) {
  if (!is_real(type)) return bits;
  const Wide sign = Wide{1} << (8 * component_bytes(type) - 1);
  return bits & sign ? sign - 1 - (bits - sign) : sign + bits;
}

template <class Real, class Bits>
std::uint64_t continued(std::uint64_t l, std::uint64_t a, std::uint64_t b) {
  const auto number = [](std::uint64_t bits) {
    return std::bit_cast<Real>(static_cast<Bits>(bits));
  };
  const volatile Real step = number(a) - number(b);
  const volatile Real sum = number(l) + step;
  return std::isnan(sum) ? 0 : std::bit_cast<Bits>(static_cast<Real>(sum));
}

class Definition {
 public:
  Definition(const Level& level, std::string filter)
      : level_(level),
        type_(level.filter_level.schema.type),
        filter_(std::move(filter)),
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
            else if (filter_ == "columns" && r == 0)
              predicted = c == 1 ? order(bits(0, 0), type_)
                                 : 2 * order(bits(0, c - 1), type_) - order(bits(0, c - 2), type_);
            else if (filter_ == "columns")
              predicted =
                  along(bits(r - 1, c), r > 1 ? std::optional(bits(r - 2, c)) : std::nullopt);
            else if (r == 0)
              predicted =
                  along(bits(0, c - 1), c > 1 ? std::optional(bits(0, c - 2)) : std::nullopt);
            else if (c == 0)
              predicted =
                  along(bits(r - 1, 0), r > 1 ? std::optional(bits(r - 2, 0)) : std::nullopt);
            else
              predicted = inside(bits(r, c - 1), bits(r - 1, c), bits(r - 1, c - 1));
            const std::size_t length = shape == SlotShape::kHalf ? n - r : n;
            const std::size_t word = filter_ == "columns"
                                         ? place(r, 0) * components_ + i * length + c
                                         : place(r, c) * components_ + i;
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
  Wide along(std::uint64_t l, std::optional<std::uint64_t> k) const {
    if (filter_ == "lorenzo" || !k) return order(l, type_);
    return inside(l, l, *k);
  }
  Wide inside(std::uint64_t l, std::uint64_t a, std::uint64_t b) const {
    if (filter_ == "lorenzo") return order(l, type_) + order(a, type_) - order(b, type_);
    return order(width_ == 4 ? continued<float, std::uint32_t>(l, a, b)
                             : continued<double, std::uint64_t>(l, a, b),
                 type_);
  }

  const Level& level_;
  ComponentType type_;
  std::string filter_;
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
      bits = type == ComponentType::kFloat32   ? std::bit_cast<std::uint32_t>(float(wave))
             : type == ComponentType::kFloat64 ? std::bit_cast<std::uint64_t>(wave)
                                               : std::uint64_t(wave * 50);
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
    if (kind == Kind::kSpecial && !is_real(type)) bits = random() % 2 ? ~std::uint64_t{0} : 0;
    std::memcpy(bytes.data() + at, &bits, width);
  }
  return bytes;
}

std::size_t first_difference_of_slots(const Bytes& a, const Bytes& b) {
  std::size_t count = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

void check_level(const Level& level, const std::string& name) {
  const auto filter = level.make(name);
  Definition definition(level, name);
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

TEST_CASE("SlotFilters_EveryShapeTypeAndRecord_AreTheirDefinitionAndInverse") {
  for (const char* name : {"lorenzo", "parallelogram", "columns"})
    for (const ComponentType type : kAllTypes)
      for (const std::uint32_t components : {1u, 2u, 3u, 4u, 5u, 9u}) {
        if (name != std::string("lorenzo") && !is_real(type)) continue;
        for (const char* pattern : {"w", "h", "wh", "wwwwwh", "w-wwhw-", "-h", "wwwwwww-hh"})
          for (int refinements = 1; refinements <= 4; ++refinements) {
            CAPTURE(name, to_string(type), components, pattern, refinements);
            check_level(Level(pattern, 23, refinements, {"x", type, components}, 1 << 12), name);
          }
      }
}

TEST_CASE("SlotFilters_LargeSlots_AreTheirDefinitionAndInverse") {
  for (const char* name : {"lorenzo", "parallelogram", "columns"})
    for (const int refinements : {5, 7}) {
      CAPTURE(name, refinements);
      check_level(Level("wwwwwhw", 14, refinements, {"x", ComponentType::kFloat32, 3}), name);
      check_level(Level("whw", 5, refinements, {"x", ComponentType::kFloat64, 3}), name);
    }
}

TEST_CASE("SlotFilters_OnEveryInstructionSet_AreTheirDefinitionAndInverse") {
  fused_rows::on_every_target([](const char* target) {
    for (const char* name : {"lorenzo", "parallelogram", "columns"})
      for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kInt32})
        for (const std::uint32_t components : {1u, 2u, 3u, 4u}) {
          if (name != std::string("lorenzo") && !is_real(type)) continue;
          // More slots than any vectors hold, and some that are left over.
          for (const int refinements : {1, 2, 3, 4, 5, 6}) {
            CAPTURE(target, name, to_string(type), components, refinements);
            check_level(Level("wwwwwwwwh", 41, refinements, {"x", type, components}), name);
          }
        }
  });
}

TEST_CASE("SlotFilters_LevelWithoutSlots_HasNothingToFilter") {
  const Level level("-", 5, 3, {"x", ComponentType::kFloat32, 3});
  CHECK(level.geometry.total_bytes() == 0);
  for (std::uint64_t block = 0; block < level.geometry.block_count(); ++block)
    for (const char* name : {"lorenzo", "parallelogram", "columns"})
      CHECK(encode(*level.make(name), block, {}).empty());
}

TEST_CASE("FloatFilters_APlane_LeaveNothingInsideASlot") {
  const Level level("w", 4, 4, {"x", ComponentType::kFloat32, 1});
  Bytes raw(level.geometry.block_bytes(0));
  for (std::size_t i = 0; i < raw.size() / 4; ++i) {
    const float value = float(i / 64) + 0.25f * float(i / 8 % 8) - 0.5f * float(i % 8);
    std::memcpy(raw.data() + 4 * i, &value, 4);
  }
  for (const char* name : {"parallelogram", "columns"}) {
    const Bytes filtered = encode(*level.make(name), 0, raw);
    for (std::size_t i = 0; i < raw.size() / 4; ++i) {
      const std::size_t row = i / 8 % 8, column = i % 8;
      // Straight lines need two numbers: `columns` has them in each column.
      if (row + column <= 1 || (name == std::string("columns") && row <= 1)) continue;
      std::uint32_t word;
      std::memcpy(&word, filtered.data() + 4 * i, 4);
      CAPTURE(name, i);
      CHECK(word == 0);
    }
  }
}

TEST_CASE("Lorenzo_AFewNumbers_HaveTheBytesOfThePage") {
  const Level level("w", 2, 2, {"x", ComponentType::kInt16, 1});
  const std::int16_t numbers[] = {100, 103, 98, 102, 90, 90, 90, 91};
  const std::uint16_t expected[] = {200, 6, 3, 2, 19, 0, 0, 2};
  Bytes raw(sizeof(numbers));
  std::memcpy(raw.data(), numbers, sizeof(numbers));
  const Bytes filtered = encode(*level.make("lorenzo"), 0, raw);
  CHECK(std::memcmp(filtered.data(), expected, sizeof(expected)) == 0);
}

TEST_CASE("Parallelogram_AFewNumbers_HaveTheBytesOfThePage") {
  const Level level("w", 1, 2, {"x", ComponentType::kFloat32, 1});
  // The prediction of the last one is 2 + (1.5 - 1) = 2.5, which is two units in the last place
  // more.
  const float numbers[] = {1, 1.5, 2, std::nextafterf(std::nextafterf(2.5, 0), 0)};
  const std::uint32_t expected[] = {0x7f000000, 0x00800000, 0x01000000, 3};
  Bytes raw(sizeof(numbers));
  std::memcpy(raw.data(), numbers, sizeof(numbers));
  const Bytes filtered = encode(*level.make("parallelogram"), 0, raw);
  CHECK(std::memcmp(filtered.data(), expected, sizeof(expected)) == 0);
}

TEST_CASE("Columns_AFewNumbers_HaveTheBytesOfThePage") {
  const Level level("w", 1, 2, {"x", ComponentType::kFloat32, 2});
  // Two rows of two records of two components. The words of a row are grouped by component.
  const float numbers[] = {1, -1, 1.5, -1, 2, std::nextafterf(-1, 0), 1.5, -1.5};
  const std::uint32_t expected[] = {0x7f000000, 0x00800000, 0x7f000001, 0,
                                    0x01000000, 0,          2,          0x007fffff};
  Bytes raw(sizeof(numbers));
  std::memcpy(raw.data(), numbers, sizeof(numbers));
  const Bytes filtered = encode(*level.make("columns"), 0, raw);
  std::uint32_t found[8];
  std::memcpy(found, filtered.data(), sizeof found);
  for (int i = 0; i < 8; ++i) {
    CAPTURE(i, found[i], expected[i]);
    CHECK(found[i] == expected[i]);
  }
}

TEST_CASE("FloatFilters_UnderOtherRounding_HaveTheSameBytes") {
  const Level level("wh", 8, 4, {"x", ComponentType::kFloat32, 3});
  const std::string name = GENERATE("parallelogram", "columns");
  const auto filter = level.make(name);
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

TEST_CASE("FloatFilters_OfIntegers_AreRefusedInWords") {
  const std::string filter = GENERATE("parallelogram", "columns");
  for (const ComponentType type : kAllTypes) {
    FilterLevel level;
    level.schema = {"colour", type, 4};
    if (is_real(type)) {
      CHECK_NOTHROW(default_pipelines().make(filter + "+shuffle,zstd:1", level));
      continue;
    }
    try {
      default_pipelines().make(filter + ",zstd:1", level);
      FAIL("accepted");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kNotSupported);
      CHECK_THAT(error.what(), Catch::Contains("'colour'") && Catch::Contains("lorenzo"));
    }
  }
}

TEST_CASE("SlotFilters_TakeNoOptions") {
  for (const char* pipeline :
       {"lorenzo:2,none", "parallelogram:x,none", "columns:2,none", "bytedelta:3,none"})
    CHECK_THROWS_AS(default_pipelines().make(pipeline, {}), Error);
}

}  // namespace plait::test
