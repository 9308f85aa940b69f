// is_utf8_text(): all code points and all malformed sequences of the standard's table.
#include "base/text.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

namespace plait::test {
namespace {

std::string encoded(std::uint32_t point) {
  const auto byte = [](std::uint32_t value) { return static_cast<char>(value); };
  const auto next = [&](int shift) { return byte(0x80 | (point >> shift & 0x3f)); };
  if (point < 0x80) return {byte(point)};
  if (point < 0x800) return {byte(0xc0 | point >> 6), next(0)};
  if (point < 0x10000) return {byte(0xe0 | point >> 12), next(6), next(0)};
  return {byte(0xf0 | point >> 18), next(12), next(6), next(0)};
}

}  // namespace

TEST_CASE("Utf8Text_EachCodePoint_IsTextUnlessItIsAControlCharacterOrASurrogate") {
  int wrong = 0;
  for (std::uint32_t point = 0; point < 0x1fffff; ++point) {
    const bool control =
        (point < 0x20 && point != '\t' && point != '\n') || (point >= 0x7f && point < 0xa0);
    const bool text = !control && point <= 0x10ffff && !(point >= 0xd800 && point < 0xe000);
    wrong += is_utf8_text("a" + encoded(point) + "b") != text;
  }
  CHECK(wrong == 0);
}

TEST_CASE("Utf8Text_MalformedSequences_AreNone") {
  // Shorter forms of the same point, stray and missing bytes, bytes that begin nothing.
  for (const char* text :
       {"\xc1\xbf", "\xe0\x9f\xbf", "\xf0\x8f\xbf\xbf", "\x80", "\xbf", "\xc3", "\xe2\x82",
        "\xf0\x9f\x98", "\xe2(\xa1", "\xfe", "\xff", "\xf8\x88\x80\x80\x80"})
    CHECK_FALSE(is_utf8_text(text));
  CHECK(is_utf8_text(""));
  CHECK_FALSE(is_utf8_text(std::string_view("a\0b", 3)));
}

namespace {

enum class Fruit { kApple, kPear, kUnnamed };
constexpr NameTable<Fruit, 2> kFruits("fruit", {{Fruit::kApple, "apple"}, {Fruit::kPear, "pear"}});

}  // namespace

TEST_CASE("NameTable_EveryName_IsThatOfItsValue") {
  CHECK(kFruits.find("pear") == Fruit::kPear);
  CHECK(kFruits.name_of(Fruit::kApple) == "apple");
  CHECK(kFruits.name_of(Fruit::kUnnamed) == "unknown");
  CHECK(kFruits.names() == "apple, pear");
}

TEST_CASE("NameTable_OtherNames_AreRefusedWithTheKnownOnes") {
  CHECK_THROWS_WITH(kFruits.find("plum"), "unknown fruit 'plum', expected apple, pear");
  CHECK_THROWS_WITH(kFruits.find(""), "unknown fruit '', expected apple, pear");
  CHECK_THROWS_WITH(kFruits.find(std::string(5000, 'x')),
                    "unknown fruit '" + std::string(100, 'x') + "', expected apple, pear");
}

}  // namespace plait::test
