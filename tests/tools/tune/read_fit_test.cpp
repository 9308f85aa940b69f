// How well reads overlap disk and processor, from made-up probes.
#include "tune/read_fit.h"

#include <catch2/catch.hpp>

#include "tune/pick.h"

namespace plait::tune {
namespace {

constexpr std::uint64_t kFitBlock = 1 << 20;

/// 1 GB/s and one processor.
Machine fit_machine() {
  return {{.name = "made up", .read = 1e9, .write = 1e9, .random_read = 1e9, .is_measured = true},
          1,
          {}};
}

/// Two pipelines of one attribute: as it is, 1 s of disk; and a half of it, 2 s to decode.
Trials fit_trials() {
  Trials made;
  made.attributes.push_back({{"position"}, 1e9, 1, true});
  made.trials.push_back({0, kFitBlock, "none", kFitBlock, false, {{1e9, 1e9, 0, 0, 1}}});
  made.trials.push_back({0, kFitBlock, "lz4", kFitBlock, false, {{1e9, 5e8, 1, 2, 1}}});
  return made;
}

/// Work of `disk` and `decode` seconds, read in `seconds`.
ReadProbe probe(double disk, double decode, double seconds) {
  ReadProbe made;
  made.choice = {kFitBlock, {0}};
  made.works = {{1e9 * disk, 0, decode, 0, 0, false}};
  made.seconds = {seconds};
  return made;
}

}  // namespace

TEST_CASE("Fit_FindsOverlapAndFactor") {
  // Perfect overlap, a tenth slower than the parts say.
  const ReadFit overlapped =
      fit_reads({probe(1, 0.1, 1.1), probe(1, 1, 1.1), probe(0.2, 1, 1.1)}, fit_machine());
  CHECK(overlapped.added == Approx(0).margin(0.03));
  CHECK(overlapped.factor == Approx(1.1).epsilon(0.02));
  // No overlap at all.
  const ReadFit in_turn =
      fit_reads({probe(1, 0.1, 1.1), probe(1, 1, 2), probe(0.2, 1, 1.2)}, fit_machine());
  CHECK(in_turn.added == Approx(1).margin(0.03));
  CHECK(in_turn.factor == Approx(1).epsilon(0.02));
  CHECK(fit_reads({}, fit_machine()).factor == 1);
  CHECK(fit_reads({probe(0, 0, 0)}, fit_machine()).factor == 1);
}

TEST_CASE("Corrections_MakePredictionsOfProbedChoicesExact") {
  Trials from = fit_trials();
  Machine measured = fit_machine();
  ReadProbe raw = probe(1, 0, 1.5), small = probe(0.5, 2, 2.2);
  small.choice = {kFitBlock, {1}};
  measured.reading = fit_reads({raw, small}, measured);
  from.corrections = corrections_of(from, {raw, small}, measured);
  REQUIRE(from.corrections.size() == 2);
  CHECK(from.corrections[0].stores_raw);
  CHECK(!from.corrections[1].stores_raw);
  CHECK(predict(work_of(from, raw.choice), measured).read == Approx(1.5));
  CHECK(predict(work_of(from, small.choice), measured).read == Approx(2.2));
  CHECK(was_probed(from, small.choice));
  // On another disk only the fit counts.
  Machine other = measured;
  other.disk.is_measured = false;
  CHECK(predict(work_of(from, raw.choice), other).read == Approx(measured.reading.factor));
}

TEST_CASE("Pick_BelievesTheProbe_NotTheModel") {
  Trials from = fit_trials();
  CHECK(from.trials[pick(from, Goal::kRead, fit_machine()).trials[0]].pipeline == "none");
  // As it is, the disk takes three times what it takes in long runs.
  ReadProbe raw = probe(1, 0, 3), small = probe(0.5, 2, 2);
  small.choice = {kFitBlock, {1}};
  from.corrections = corrections_of(from, {raw, small}, fit_machine());
  CHECK(from.trials[pick(from, Goal::kRead, fit_machine()).trials[0]].pipeline == "lz4");
  // A difference of 3 % is none.
  raw.seconds = {2.05};
  from.corrections = corrections_of(from, {raw, small}, fit_machine());
  CHECK(from.trials[pick(from, Goal::kRead, fit_machine()).trials[0]].pipeline == "none");
}

TEST_CASE("Rates_BetweenMeasuredSizesOfBlocks_AreOnALine") {
  Disk disk = fit_machine().disk;
  CHECK(rate_of(disk, 5).read == 1e9);
  disk.of_blocks = {{1 << 16, 1e8, 2e8}, {1 << 20, 5e8, 6e8}};
  CHECK(rate_of(disk, 1).read == 1e8);
  CHECK(rate_of(disk, 1 << 16).write == Approx(2e8));
  CHECK(rate_of(disk, 1 << 18).read == Approx(3e8));
  CHECK(rate_of(disk, 1 << 18).write == Approx(4e8));
  CHECK(rate_of(disk, 1e9).read == 5e8);
}

}  // namespace plait::tune
