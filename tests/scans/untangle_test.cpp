#include "sample/untangle.h"

#include <catch2/catch.hpp>

#include "collapse/decimate.h"
#include "plait/error.h"
#include "sample/turned.h"
#include "sample/walk.h"
#include "support/error_of.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

Surface flat_scan() {
  IndexedMesh flat = sheet(20, 20);
  for (Point& p : flat.positions) p.z = 0;
  return repair(flat, {}, "mesh").surface;
}

/// A base mesh of the scan's own faces, and its samples in the middle of each edge.
struct Sampled {
  Surface scan = flat_scan();
  BaseMesh base = BaseMesh::build({scan.positions, scan.faces});
  std::vector<SurfacePoint> samples;

  explicit Sampled(int level) {
    std::vector<FaceId> faces(scan.faces.size());
    for (std::size_t i = 0; i < faces.size(); ++i) faces[i] = static_cast<FaceId>(i);
    samples = sample_scan(CollapseHistory(faces.size()), base, faces, level);
  }
};

}  // namespace

TEST_CASE("Untangle_GoodSamples_StayWhereTheyAre") {
  Sampled sampled(1);
  const auto before = sampled.samples;
  const Untangled result = untangle(sampled.scan, sampled.base, 1, {}, sampled.samples);
  CHECK(result.before == 0);
  CHECK(result.moved == 0);
  CHECK(sampled.samples[50].weights == before[50].weights);
}

TEST_CASE("Untangle_SampleBeyondItsNeighbours_ComesBackWithinTheCap", "[threads]") {
  Sampled sampled(2);
  const SampleNumbers numbers(sampled.base, 2);
  const auto face = static_cast<FaceId>(sampled.scan.faces.size() / 2 + 10);
  const std::uint64_t sample = numbers.of(face, 1, 1);
  const Point edge = sampled.scan.corner(face, 1) - sampled.scan.corner(face, 0);
  sampled.samples[sample] = walk(sampled.scan, sampled.samples[sample], 0.4 * edge);
  const Point moved = position_of(sampled.scan, sampled.samples[sample]);
  const std::uint64_t turned = count_turned(sampled.scan, sampled.base, 2, sampled.samples);
  REQUIRE(turned > 0);

  auto capped = sampled.samples;
  const Untangled stays = untangle(sampled.scan, sampled.base, 2, {.most_way = 0}, capped);
  CHECK(stays.after == stays.before);

  const Untangled result = untangle(sampled.scan, sampled.base, 2, {}, sampled.samples);
  CHECK(result.before == turned);
  CHECK(result.after == 0);
  CHECK(result.moved >= 1);
  CHECK(count_turned(sampled.scan, sampled.base, 2, sampled.samples) == 0);
  CHECK(length(position_of(sampled.scan, sampled.samples[sample]) - moved) < 2 * length(edge));
}

TEST_CASE("Untangle_CancelledInEachOfItsSteps_IsAnError") {
  Sampled sampled(2);
  const auto face = static_cast<FaceId>(sampled.scan.faces.size() / 2 + 10);
  SurfacePoint& sample = sampled.samples[SampleNumbers(sampled.base, 2).of(face, 1, 1)];
  sample = walk(sampled.scan, sample,
                0.4 * (sampled.scan.corner(face, 1) - sampled.scan.corner(face, 0)));
  std::vector<std::uint64_t> steps;
  const auto listed = [&](const Progress& now) {
    if (steps.empty() || steps.back() != now.done) steps.push_back(now.done);
    return true;
  };
  auto samples = sampled.samples;
  untangle(sampled.scan, sampled.base, 2, {.progress = listed}, samples);
  CHECK(steps.size() >= 5);
  for (const std::uint64_t step : steps) {
    samples = sampled.samples;
    CHECK(error_of([&] {
            untangle(sampled.scan, sampled.base, 2,
                     {.progress = [&](const Progress& now) { return now.done < step; }}, samples);
          }).code() == ErrorCode::kCancelled);
  }
}

}  // namespace plait::test
