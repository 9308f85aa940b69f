#include "collapse/collapse_history.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "collapse/decimate.h"
#include "collapse/quadric.h"
#include "sample/samples.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
TEST_CASE("Quadric_PlanesAndPoints_IsSumOfSquaredDistances") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Point{number(random), number(random), number(random)}; };
  for (int round = 0; round < 20; ++round) {
    Quadric sum;
    const Point at = point();
    double expected = 0;
    for (int i = 0; i < 5; ++i) {
      Quadric one;
      const Point normal = normalized(point()), through = point(), near = point();
      one.add_plane(normal, through, 2);
      one.add_point(near, 0.5);
      sum = sum + one;
      const double height = dot(normal, at - through);
      expected += 2 * height * height + 0.5 * squared_length(at - near);
    }
    CHECK(sum.at(at) == Approx(expected));
    const Point best = sum.minimum({9, 9, 9});
    const double least = sum.at(best);
    for (const Point step : {Point{1e-3, 0, 0}, Point{0, 1e-3, 0}, Point{0, 0, 1e-3}}) {
      CHECK(sum.at(best + step) > least);
      CHECK(sum.at(best - step) > least);
    }
  }
}

TEST_CASE("Quadric_OnePlane_HasNoSingleMinimum") {
  Quadric plane;
  plane.add_plane({0, 0, 1}, {0, 0, 3}, 1);
  CHECK(plane.minimum({4, 5, 6}) == Point{4, 5, 6});
}

namespace {

struct Remeshed {
  Surface scan;
  Decimated decimated;
  BaseMesh base;
};

Remeshed remesh(const IndexedMesh& mesh, std::uint64_t faces) {
  Remeshed result;
  result.scan = repair(mesh, {}, "mesh").surface;
  result.decimated = decimate(result.scan, {.faces = faces});
  result.base = BaseMesh::build({result.decimated.positions, result.decimated.faces});
  return result;
}

std::vector<SurfacePoint> samples_of(const Remeshed& remeshed, int level) {
  return sample_scan(remeshed.decimated.history, remeshed.base, remeshed.decimated.scan_faces,
                     level);
}

}  // namespace

TEST_CASE("FollowBack_WithoutCollapses_IsThePointItself") {
  const CollapseHistory history(4);
  const SurfacePoint point{2, {0.5, 0.25, 0.25}};
  const SurfacePoint back = history.follow_back(point);
  CHECK(back.face == 2);
  CHECK(back.weights == point.weights);
}

TEST_CASE("FollowBack_EveryPoint_IsInsideAFaceOfTheScan") {
  for (const IndexedMesh& mesh :
       {torus_grid(40, 30), sheet(30, 20), random_sphere(3, 900), random_sheet(5, 900)}) {
    const Remeshed remeshed = remesh(mesh, 60);
    std::size_t outside = 0;
    for (const SurfacePoint& p : samples_of(remeshed, 4)) {
      const double sum = p.weights[0] + p.weights[1] + p.weights[2];
      const double least = std::min({p.weights[0], p.weights[1], p.weights[2]});
      if (p.face >= remeshed.scan.faces.size() || !(least >= 0) || std::abs(sum - 1) > 1e-12)
        ++outside;
    }
    CHECK(outside == 0);
  }
}

TEST_CASE("FollowBack_FlatSquare_IsABijection") {
  IndexedMesh flat = sheet(24, 24);
  for (Point& p : flat.positions) p.z = 0;
  const Remeshed remeshed = remesh(flat, 40);
  const int level = 6;
  const auto samples = samples_of(remeshed, level);
  const SampleNumbers numbers(remeshed.base, level);
  // The images of small triangles cover the square once: none is turned, and their areas sum up.
  double positive = 0, negative = 0;
  for (FaceId face = 0; face < remeshed.base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
      const double area = area_vector(position_of(remeshed.scan, samples[a]),
                                      position_of(remeshed.scan, samples[b]),
                                      position_of(remeshed.scan, samples[c]))
                              .z;
      (area >= 0 ? positive : negative) += area;
    });
  double whole = 0;
  for (const auto& [a, b, c] : flat.faces)
    whole += area_vector(flat.positions[a], flat.positions[b], flat.positions[c]).z;
  CHECK(negative > -1e-3 * whole);
  CHECK(positive + negative == Approx(whole).epsilon(0.01));
  // Every face of the scan is met.
  std::vector<bool> met(flat.faces.size(), false);
  for (const SurfacePoint& p : samples) met[p.face] = true;
  CHECK(std::count(met.begin(), met.end(), false) == 0);
}

TEST_CASE("FollowBack_NeighboursOnTheTorus_StayNeighbours") {
  const Remeshed remeshed = remesh(torus_grid(40, 30), 60);
  const int level = 5;
  const auto samples = samples_of(remeshed, level);
  const SampleNumbers numbers(remeshed.base, level);
  double longest = 0, sum = 0, count = 0;
  for (FaceId face = 0; face < remeshed.base.face_count(); ++face)
    numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t) {
      const double edge =
          length(position_of(remeshed.scan, samples[a]) - position_of(remeshed.scan, samples[b]));
      longest = std::max(longest, edge);
      sum += edge;
      ++count;
    });
  CHECK(longest < 12 * sum / count);
}

TEST_CASE("Samples_AnyNumberOfThreads_HaveTheSameBits", "[threads]") {
  const Remeshed remeshed = remesh(torus_grid(40, 30), 200);
  std::vector<std::vector<SurfacePoint>> all;
  for (const int threads : {1, 2, 4})
    tbb::task_arena(threads).execute([&] { all.push_back(samples_of(remeshed, 3)); });
  for (const auto& samples : all)
    CHECK(std::equal(samples.begin(), samples.end(), all[0].begin(), all[0].end(),
                     [](const SurfacePoint& a, const SurfacePoint& b) {
                       return a.face == b.face && a.weights == b.weights;
                     }));
}

}  // namespace plait::test
