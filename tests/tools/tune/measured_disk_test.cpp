// What measuring a disk gives whatever the disk does.
#include "tune/measured_disk.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "support/temporary_directory.h"

namespace plait::tune {
namespace {

MeasuredDisk measure(const test::TemporaryDirectory& here, std::uint64_t most_bytes) {
  return measure_disk(here.path(), most_bytes, {64 << 10, 1 << 20}, 2, 0, [] { return true; });
}

}  // namespace

TEST_CASE("MeasureDisk_OfAFewBlocks_TakesTheirOrderForNoBurst") {
  const test::TemporaryDirectory here;
  for (const std::uint64_t blocks : {1u, 2u, 3u, 5u}) {
    const MeasuredDisk found = measure(here, blocks << 20);
    CAPTURE(blocks);
    CHECK(found.bytes == blocks << 20);
    CHECK(found.disk.burst_bytes == 0);
    REQUIRE(found.floors.size() == 2);
    CHECK(found.floors[1].read.value > 0);
    CHECK(found.disk.read == found.floors[1].read.value);
  }
  CHECK(std::filesystem::is_empty(here.path()));
}

}  // namespace plait::tune
