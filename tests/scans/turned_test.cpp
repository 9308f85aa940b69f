#include "sample/turned.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

#include "collapse/collapse_history.h"
#include "sample/folds.h"
#include "sample/walk.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

constexpr int kFineLevel = 2;

/// A flat scan, which is its own base mesh. A sample inside of one face is beyond its neighbours.
struct TurnedCase {
  Surface scan = [] {
    IndexedMesh mesh = sheet(12, 12);
    for (Point& p : mesh.positions) p.z = 0;
    return repair(mesh, {}, "mesh").surface;
  }();
  BaseMesh base = BaseMesh::build({scan.positions, scan.faces});
  FaceId face = static_cast<FaceId>(scan.faces.size() / 2 + 10);
  std::vector<SurfacePoint> samples;

  TurnedCase() {
    std::vector<FaceId> faces(scan.faces.size());
    std::iota(faces.begin(), faces.end(), FaceId{0});
    samples = sample_scan(CollapseHistory(faces.size()), base, faces, kFineLevel);
    SurfacePoint& inner = samples[SampleNumbers(base, kFineLevel).of(face, 1, 1)];
    inner = walk(scan, inner, 0.4 * (scan.corner(face, 1) - scan.corner(face, 0)));
  }
};

}  // namespace

TEST_CASE("ForEachTurned_OneSampleBeyondItsNeighbours_NamesTrianglesOfItsFace") {
  const TurnedCase sampled;
  const SampleNumbers numbers(sampled.base, kFineLevel);
  const std::uint64_t moved = numbers.of(sampled.face, 1, 1);
  std::uint64_t count = 0;
  for_each_turned(
      sampled.scan, sampled.base, kFineLevel, sampled.samples, false,
      [&](FaceId face, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        ++count;
        CHECK(face == sampled.face);
        CHECK((a == moved || b == moved || c == moved));
        // The scan is flat: a turned triangle has a normal that points down.
        const auto at = [&](std::uint64_t sample) {
          return position_of(sampled.scan, sampled.samples[sample]);
        };
        CHECK(area_vector(at(a), at(b), at(c)).z * face_normal(sampled.scan, face).z < 0);
      });
  CHECK(count > 0);
  CHECK(count == count_turned(sampled.scan, sampled.base, kFineLevel, sampled.samples));
}

TEST_CASE("WeighTurnedFaces_Again_MultipliesTheWeightsThere") {
  const TurnedCase sampled;
  std::vector<float> weights(sampled.scan.positions.size(), 1);
  for (const float expected : {8.0F, 64.0F}) {
    weigh_turned_faces(sampled.scan, sampled.base, kFineLevel, sampled.samples, false, 8, weights);
    // Samples of the face lie on it, or, on its sides, on the faces beside it.
    const auto& corners = sampled.scan.faces[sampled.face];
    for (const VertexId vertex : corners) CHECK(weights[vertex] == expected);
    const Point middle = sampled.scan.corner(sampled.face, 0);
    std::size_t wrong = 0;
    for (std::size_t vertex = 0; vertex < weights.size(); ++vertex) {
      const bool far = length(sampled.scan.positions[vertex] - middle) > 3;
      if (far ? weights[vertex] != 1 : weights[vertex] != 1 && weights[vertex] != expected) ++wrong;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("CountFolds_SmallTrianglesInFacesAndAcrossTheirSides_AreThoseOfTheMesh", "[threads]") {
  for (const IndexedMesh& coarse : {octahedron(), annulus(5), sheet(3, 2)}) {
    const BaseMesh base = BaseMesh::build(coarse);
    for (const int level : {1, 2, 3}) {
      const SampleNumbers numbers(base, level);
      IndexedMesh small;
      std::uint32_t state = 5;
      for (std::uint64_t sample = 0; sample < numbers.count(); ++sample) {
        Point& p = small.positions.emplace_back();
        for (int axis = 0; axis < 3; ++axis) {
          state = state * 1664525 + 1013904223;
          p[axis] = static_cast<double>(state >> 16);
        }
      }
      for (FaceId face = 0; face < base.face_count(); ++face)
        numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
          small.faces.push_back(
              {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
        });
      const std::uint64_t expected = figures_of(repair(small, {}, "small").surface).folded_edges;
      CHECK(expected > 0);
      CHECK(count_folds(base, level, small.positions) == expected);
    }
  }
}

}  // namespace plait::test
