// The formulas of docs/tune.md, in closed form.
#include "tune/disk_model.h"

#include <catch2/catch.hpp>

namespace plait::tune {
namespace {

/// 1 GB/s to read, 500 MB/s to write.
Disk disk() {
  return {.name = "made up",
          .read = 1e9,
          .write = 5e8,
          .latency = 1e-3,
          .random_read = 1e8,
          .is_measured = true};
}

/// 2e9 stored bytes.
Work work(double encode_seconds, double decode_seconds) {
  return {2e9, encode_seconds, decode_seconds, 1e5, 2e-3, false};
}

}  // namespace

TEST_CASE("Read_IsTheLongerOfDiskAndProcessors_AttributeByAttribute") {
  CHECK(predict({work(0, 1)}, {disk(), 1, {}}).read == Approx(2));
  CHECK(predict({work(0, 6)}, {disk(), 1, {}}).read == Approx(6));
  CHECK(predict({work(0, 6)}, {disk(), 2, {}}).read == Approx(3));
  // One attribute waits for the disk, the other one for the processor: neither helps the other.
  CHECK(predict({work(0, 0), work(0, 6)}, {disk(), 1, {}}).read == Approx(2 + 6));
}

TEST_CASE("Read_OfADiskThatLetsABurstPass_IsFasterAtTheBeginning") {
  Disk bursting = disk();
  bursting.burst_bytes = 1e9;
  bursting.burst_read = 4e9;
  // At 4 GB/s until the burst and the lasting rate meet: (x - 1e9) / 1e9 = x / 4e9 at x = 4/3 e9.
  CHECK(seconds_to_read(bursting, 1e5, 0, 1e9) == Approx(0.25));
  CHECK(seconds_to_read(bursting, 1e5, 0, 3e9) == Approx(2));
  CHECK(seconds_to_read(bursting, 1e5, 1e9, 2e9) == Approx(1.75));
  CHECK(seconds_to_read(bursting, 1e5, 3e9, 2e9) == Approx(2));
  // The second attribute of 2e9 bytes has nothing left of it.
  const std::vector<double> reads = modelled_reads({work(0, 0), work(0, 0)}, {bursting, 1, {}});
  REQUIRE(reads.size() == 2);
  CHECK(reads[0] == Approx(1));
  CHECK(reads[1] == Approx(2));
}

TEST_CASE("Burst_FollowsFromTheHalvesOfARun") {
  const Burst none = burst_of(8e9, 0.1, 2, 2.5);
  CHECK(none.bytes == 0);
  // The second half at 1 GB/s; the first one took half as long, so 2e9 bytes passed at once, and
  // the first 0.5e9 of them at 5 GB/s.
  const Burst found = burst_of(8e9, 0.1, 2, 4);
  CHECK(found.bytes == Approx(2e9));
  CHECK(found.rate == Approx(5e9));
  CHECK(burst_of(8e9, 0, 0, 4).bytes == 0);
}

TEST_CASE("Write_BeginsWhenTheSystemWrites") {
  Disk slow_start = disk();
  CHECK(predict({work(1, 0)}, {slow_start, 1, {}}).write == Approx(4));
  CHECK(predict({work(10, 0)}, {slow_start, 1, {}}).write == Approx(10));
  // All of it is encoded before the disk begins: the sum.
  slow_start.unwritten_bytes = 1e12;
  CHECK(predict({work(10, 0)}, {slow_start, 1, {}}).write == Approx(10 + 4));
  // A quarter of it: 2.5 s alone, then the disk is the faster one of the two.
  slow_start.unwritten_bytes = 5e8;
  CHECK(predict({work(10, 0)}, {slow_start, 1, {}}).write == Approx(2.5 + 7.5));
  CHECK(predict({work(2, 0)}, {slow_start, 1, {}}).write == Approx(0.5 + 4));
  // The commit waits for all attributes together.
  slow_start.unwritten_bytes = 0;
  CHECK(predict({work(6, 0), work(0, 0)}, {slow_start, 1, {}}).write == Approx(8));
}

TEST_CASE("Update_ReadsAndWrites_UnlessLevelsAreFixed") {
  CHECK(predict({work(1, 1)}, {disk(), 1, {}}).update == Approx(2 + 4));
  CHECK(predict({work(9, 1)}, {disk(), 2, {}}).update == Approx(6));
  CHECK(predict({work(9, 3)}, {disk(), 1, {}}).update == Approx(12));
  Work fixed = work(1, 1);
  fixed.is_fixed = true;
  CHECK(!predict({fixed, work(1, 1)}, {disk(), 1, {}}).update);
  CHECK(!predict({work(1, 1), fixed}, {disk(), 1, {}}).update);
}

TEST_CASE("Patch_IsOneBlockOfEachAttribute") {
  CHECK(predict({work(0, 0)}, {disk(), 4, {}}).patch == Approx(1e-3 + 1e-3 + 2e-3));
  CHECK(predict({work(0, 0), work(0, 0)}, {disk(), 4, {}}).patch == Approx(8e-3));
}

TEST_CASE("NothingStored_TakesOnlyTheProcessor") {
  Disk cached = disk();
  cached.unwritten_bytes = 1e9;
  const Predicted predicted = predict({{0, 3, 1, 0, 0, false}}, {cached, 1, {}});
  CHECK(predicted.read == Approx(1));
  CHECK(predicted.write == Approx(3));
  CHECK(predict({}, {cached, 1, {}}).write == 0);
}

TEST_CASE("ClassesOfDisks_AreFromSlowToFast") {
  const auto classes = classes_of_disks();
  REQUIRE(classes.size() == 4);
  for (std::size_t i = 1; i < classes.size(); ++i) CHECK(classes[i - 1].read < classes[i].read);
  for (const Disk& each : classes) CHECK(!each.is_measured);
}

}  // namespace plait::tune
