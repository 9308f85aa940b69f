// Decisions from made-up figures.
#include "tune/pick.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "plait/error.h"

namespace plait::tune {
namespace {

constexpr std::uint64_t kBlock = 1 << 20;
constexpr double kRaw = 1e9;

/// Four parts. `stored` bytes a raw byte; nanoseconds a raw byte. `spread`: how much the parts
/// differ.
Trial trial(std::size_t attribute, const std::string& pipeline, double stored, double encode_ns,
            double decode_ns, double spread = 0, std::uint64_t block_bytes = kBlock) {
  Trial made{attribute, block_bytes, pipeline, static_cast<double>(block_bytes), false, {}};
  made.needs_other_blocks = pipeline.starts_with("hierarchy");
  for (int part = 0; part < 4; ++part) {
    const double factor = 1 + spread * (part % 2 == 0 ? 1 : -1);
    made.outcomes.push_back(
        {1e6, 1e6 * stored * factor, 1e-3 * encode_ns * factor, 1e-3 * decode_ns * factor, 1});
  }
  return made;
}

Trials trials(std::vector<Trial> all, std::size_t attributes = 1) {
  Trials made;
  made.attributes.push_back({{"position"}, kRaw, 4, false});
  if (attributes == 2) made.attributes.push_back({{"normal"}, kRaw, 4, false});
  made.trials = std::move(all);
  return made;
}

/// none: 1, 0.1, 0.1; lz4: half the size, decodes at 2 GB/s; hierarchy: an eighth, 0.5 GB/s.
Trials usual() {
  return trials({trial(0, "none", 1, 0.1, 0.1), trial(0, "shuffle,lz4", 0.5, 1, 0.5),
                 trial(0, "hierarchy+shuffle,zstd:1", 0.125, 4, 2),
                 trial(0, "shuffle,zstd:9", 0.6, 30, 3)});
}

Machine machine(double speed) {
  return {{.name = "made up",
           .read = speed,
           .write = speed,
           .latency = 1e-4,
           .random_read = speed,
           .is_measured = true},
          1,
          {}};
}

std::string picked(const Trials& from, Goal goal, double speed) {
  const Choice choice = pick(from, goal, machine(speed));
  return from.trials[choice.trials[0]].pipeline;
}

}  // namespace

TEST_CASE("Pick_FollowsTheDisk") {
  const Trials from = usual();
  CHECK(picked(from, Goal::kRead, 100e6) == "hierarchy+shuffle,zstd:1");
  CHECK(picked(from, Goal::kRead, 500e6) == "shuffle,lz4");
  CHECK(picked(from, Goal::kRead, 5e9) == "none");
  CHECK(picked(from, Goal::kWrite, 10e6) == "hierarchy+shuffle,zstd:1");
  CHECK(picked(from, Goal::kWrite, 2e9) == "none");
  CHECK(picked(from, Goal::kSize, 5e9) == "hierarchy+shuffle,zstd:1");
}

TEST_CASE("Pick_ForUpdates_LeavesLevelsFree") {
  CHECK(picked(usual(), Goal::kUpdate, 1e6) == "shuffle,lz4");
  const Trials fixed = trials({trial(0, "hierarchy,lz4", 0.5, 1, 1)});
  CHECK(std::isinf(
      cost(Goal::kUpdate, work_of(fixed, pick(fixed, Goal::kUpdate, machine(1e9))), machine(1e9))));
}

TEST_CASE("Pick_OfWhatSavesNothing_IsNone") {
  const Trials random_bits = trials({trial(0, "shuffle,lz4", 1, 1, 0.1),
                                     trial(0, "lz4", 1, 0.2, 0.1), trial(0, "none", 1, 0.1, 0.1)});
  for (const Goal goal : all_goals())
    for (const double speed : {50e6, 5e9}) {
      CAPTURE(to_string(goal), speed);
      CHECK(picked(random_bits, goal, speed) == "none");
    }
}

TEST_CASE("Pick_OfBlockSizes_AndOfEachAttribute") {
  Trials from = trials(
      {trial(0, "none", 1, 0.1, 0.1), trial(1, "none", 1, 0.1, 0.1), trial(0, "lz4", 0.5, 1, 0.5),
       trial(1, "lz4", 0.9, 9, 9), trial(0, "lz4", 0.4, 1, 0.5, 0, 2 * kBlock),
       trial(0, "none", 1, 0.1, 0.1, 0, 2 * kBlock), trial(1, "none", 1, 0.1, 0.1, 0, 2 * kBlock)},
      2);
  const Choice choice = pick(from, Goal::kRead, machine(500e6));
  CHECK(choice.block_bytes == 2 * kBlock);
  CHECK(to_text(from, choice) == "position=lz4 normal=none in blocks of 2MiB");
}

TEST_CASE("Compare_OfPartsThatVaryTogether_IsPaired") {
  // The sizes of the parts differ by a factor of 3, but the ratio of the two pipelines is the same
  // in each.
  const Trials paired = trials({trial(0, "a", 0.5, 1, 0.1, 0.5), trial(0, "b", 0.52, 1, 0.1, 0.5)});
  const Choice a{kBlock, {0}}, b{kBlock, {1}};
  CHECK(!no_difference(paired, Goal::kSize, a, b, machine(1e9)));
  CHECK(compare(paired, Goal::kSize, a, b, machine(1e9)).value == Approx(std::log(0.5 / 0.52)));
  // Against each other, they do not: no difference that the sample shows.
  const Trials against =
      trials({trial(0, "a", 0.5, 1, 0.1, 0.5), trial(0, "b", 0.52, 1, 0.1, -0.5)});
  CHECK(no_difference(against, Goal::kSize, a, b, machine(1e9)));
  CHECK(no_difference(against, Goal::kSize, a, a, machine(1e9)));
}

TEST_CASE("Front_HasTheBreakEvenOfNeighbours") {
  const Trials from = usual();
  const auto front = front_of(from, Goal::kRead, kBlock, machine(1e9));
  REQUIRE(front.size() == 3);  // zstd:9 is larger and slower than lz4
  CHECK(from.trials[front[0].choice.trials[0]].pipeline == "hierarchy+shuffle,zstd:1");
  CHECK(from.trials[front[2].choice.trials[0]].pipeline == "none");
  // max(125e6 / D, 2) = max(500e6 / D, 0.5), and max(500e6 / D, 0.5) = max(1e9 / D, 0.1).
  CHECK(front[0].next_from.value() == Approx(250e6).epsilon(1e-3));
  CHECK(front[1].next_from.value() == Approx(2e9).epsilon(1e-3));
  CHECK(!front[2].next_from);
}

TEST_CASE("Sentence_NamesTheSpeedsBetweenChoices") {
  const Trials from = usual();
  const auto ranges = best_at_speeds(from, Goal::kRead, kBlock, machine(1e9));
  REQUIRE(ranges.size() == 3);
  CHECK(ranges[0].slowest == 0);
  CHECK(ranges[0].fastest == Approx(250e6).epsilon(1e-3));
  CHECK(ranges[1].slowest == ranges[0].fastest);
  CHECK(std::isinf(ranges[2].fastest));
  CHECK(sentence(from, Goal::kRead, ranges) ==
        "For a full read: on disks slower than 250 MB/s choose hierarchy+shuffle,zstd:1 in blocks "
        "of 1MiB; else slower than 2 GB/s choose shuffle,lz4 in blocks of 1MiB; else none in "
        "blocks of 1MiB.");
  CHECK(sentence(from, Goal::kSize, best_at_speeds(from, Goal::kSize, kBlock, machine(1e9))) ==
        "For size: choose hierarchy+shuffle,zstd:1 in blocks of 1MiB on every disk.");
}

TEST_CASE("Pick_AfterAnInterruption_ComparesTheSameParts") {
  Trials from = usual();
  for (Trial& each : from.trials)
    for (std::size_t part = 1; part < 4; ++part) each.outcomes[part] = {};
  CHECK(picked(from, Goal::kRead, 100e6) == "hierarchy+shuffle,zstd:1");
  CHECK(picked(from, Goal::kRead, 1.9e9) == "none");  // one part shows no small difference
  from.trials[2].outcomes[0] = {};                    // hierarchy was not reached
  CHECK(front_of(from, Goal::kRead, kBlock, machine(1e9)).size() == 2);
}

TEST_CASE("Goals_HaveNames") {
  for (const Goal goal : all_goals()) CHECK(goal_from_name(to_string(goal)) == goal);
  CHECK_THROWS_AS(goal_from_name("speed"), Error);
  CHECK(cost(Goal::kBalanced, {{8e9, 1, 1, 0, 0, false}}, machine(1e9)) ==
        Approx(std::cbrt(8.0 * 8.0 * 8e9)));
}

}  // namespace plait::tune
