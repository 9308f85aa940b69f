#include <catch2/catch.hpp>

#include "base/text.h"

namespace plait::test {
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
