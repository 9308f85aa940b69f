// The loops over bytes, against their definitions, with every instruction set of this processor.
#include "compressed/filters/byte_planes.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

#include "rows/every_target.h"

namespace plait::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

std::size_t different(const Bytes& a, const Bytes& b) {
  std::size_t count = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += a[i] != b[i];
  return count;
}

constexpr std::size_t kCounts[] = {0,  1,  2,  7,  8,   9,   15,  16,  17,   31,  32,
                                   33, 63, 64, 65, 127, 128, 129, 255, 1000, 4099};

}  // namespace

TEST_CASE("BytePlanes_SplitAndJoin_AreTheDefinitionOnEveryInstructionSet") {
  fused_rows::on_every_target([](const char* target) {
    for (const std::size_t width : {2u, 4u, 8u})
      for (const std::size_t count : kCounts) {
        CAPTURE(target, width, count);
        const Bytes numbers = random_bytes(count * width, 1);
        Bytes expected(numbers.size()), planes(numbers.size()), back(numbers.size());
        for (std::size_t i = 0; i < count; ++i)
          for (std::size_t plane = 0; plane < width; ++plane)
            expected[plane * count + i] = numbers[i * width + plane];
        split_planes(numbers.data(), count, width, planes.data());
        CHECK(different(planes, expected) == 0);
        join_planes(planes.data(), count, width, back.data());
        CHECK(different(back, numbers) == 0);
      }
  });
}

}  // namespace plait::test
