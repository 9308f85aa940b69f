// Relaxed samples follow the scan more closely, and keep what they must.
#include "sample/relax.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "collapse/decimate.h"
#include "distance/distances.h"
#include "sample/untangle.h"
#include "support/error_of.h"
#include "support/test_meshes.h"
#include "surface/repair.h"

namespace plait::test {
namespace {

struct RelaxCase {
  Surface scan;
  BaseMesh base;
  int level;
  std::vector<SurfacePoint> samples;

  RelaxCase(const IndexedMesh& mesh, std::uint64_t faces, int at_level)
      : scan(repair(mesh, {}, "mesh").surface), level(at_level) {
    const Decimated decimated = decimate(scan, {.faces = faces});
    base = BaseMesh::build({decimated.positions, decimated.faces});
    samples = sample_scan(decimated.history, base, decimated.scan_faces, level);
  }

  std::uint64_t relax(int rounds = 3) {
    return plait::relax(scan, base, level, {.rounds = rounds}, samples);
  }
  IndexedMesh small_triangles() const {
    IndexedMesh mesh;
    for (const SurfacePoint& sample : samples) mesh.positions.push_back(position_of(scan, sample));
    const SampleNumbers numbers(base, level);
    for (FaceId face = 0; face < base.face_count(); ++face)
      numbers.for_each_triangle(face, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        mesh.faces.push_back(
            {static_cast<VertexId>(a), static_cast<VertexId>(b), static_cast<VertexId>(c)});
      });
    return mesh;
  }
  double distance() const {
    const IndexedMesh small = small_triangles();
    const TriangleSet from{scan.positions, scan.faces}, to{small.positions, small.faces};
    return measure_distances(from, TriangleTree(to.positions, to.faces), to, {.samples = 20000})
        .rms;
  }
};

/// A sheet with waves across it.
IndexedMesh waves() {
  IndexedMesh mesh = sheet(60, 60);
  for (Point& p : mesh.positions) p.z = 4 * std::sin(0.3 * p.x + 0.11 * p.y);
  return mesh;
}

}  // namespace

TEST_CASE("Relax_BentSurfaces_AreCloserToTheScan") {
  for (const IndexedMesh& mesh : {torus_grid(60, 40), waves()}) {
    RelaxCase sampled(mesh, 60, 3);
    const double before = sampled.distance();
    CHECK(sampled.relax() > 0);
    CHECK(sampled.distance() < 0.95 * before);
  }
}

TEST_CASE("Relax_EveryMesh_TurnsNoTriangleOverAndKeepsBorders") {
  for (const IndexedMesh& mesh :
       {waves(), torus_grid(40, 30), random_sphere(5, 900), random_sheet(5, 900),
        side_by_side({sheet(9, 9), sheet(20, 7)})}) {
    for (const int level : {1, 2, 3}) {
      RelaxCase sampled(mesh, 60, level);
      const std::vector<SurfacePoint> before = sampled.samples;
      const std::uint64_t turned = count_turned(sampled.scan, sampled.base, level, sampled.samples);
      const std::uint64_t moved = sampled.relax();
      CHECK(count_turned(sampled.scan, sampled.base, level, sampled.samples) <= turned);
      std::vector<bool> border(before.size(), false);
      const Topology topology = sampled.base.topology();
      const SampleNumbers numbers(sampled.base, level);
      for (FaceId face = 0; face < sampled.base.face_count(); ++face)
        for (std::int64_t i = 0; i <= numbers.size(); ++i) {
          const std::array<std::uint64_t, 3> on_side = {numbers.of(face, numbers.size() - i, i),
                                                        numbers.of(face, 0, i),
                                                        numbers.of(face, i, 0)};
          for (int side = 0; side < 3; ++side)
            if (!topology.across(FaceSide(face, side)).exists())
              border[on_side[static_cast<std::size_t>(side)]] = true;
        }
      std::size_t changed = 0, on_border = 0, outside = 0;
      for (std::size_t i = 0; i < before.size(); ++i) {
        const SurfacePoint& p = sampled.samples[i];
        if (std::min({p.weights[0], p.weights[1], p.weights[2]}) < 0) ++outside;
        if (p.face == before[i].face && p.weights == before[i].weights) continue;
        ++changed;
        on_border += border[i] ? 1u : 0u;
      }
      CHECK(changed <= moved);
      CHECK(on_border == 0);
      CHECK(outside == 0);
    }
  }
}

TEST_CASE("Relax_SmallTrianglesOfAFace_StayWithinTwiceTheirMeanArea") {
  RelaxCase sampled(torus_grid(60, 40), 100, 3);
  const auto beyond = [&] {
    const IndexedMesh small = sampled.small_triangles();
    std::size_t count = 0;
    for (std::size_t first = 0; first < small.faces.size(); first += 64) {
      std::vector<double> areas;
      double sum = 0;
      for (std::size_t i = first; i < first + 64; ++i) {
        const auto& [a, b, c] = small.faces[i];
        areas.push_back(
            length(area_vector(small.positions[a], small.positions[b], small.positions[c])));
        sum += areas.back() / 64;
      }
      for (const double area : areas) count += area > 2.5 * sum || area < 0.4 * sum ? 1u : 0u;
    }
    return count;
  };
  const std::size_t before = beyond();
  sampled.relax();
  CHECK(beyond() <= before + 10);
}

TEST_CASE("Relax_AnyNumberOfThreads_GivesTheSameBits") {
  for (const int level : {1, 2, 3}) {
    const RelaxCase first(torus_grid(60, 40), 300, level);
    std::vector<std::vector<SurfacePoint>> all;
    for (const int threads : {1, 2, 4})
      tbb::task_arena(threads).execute([&] {
        RelaxCase sampled = first;
        sampled.relax();
        all.push_back(sampled.samples);
      });
    for (const auto& samples : all)
      CHECK(std::equal(samples.begin(), samples.end(), all[0].begin(), all[0].end(),
                       [](const SurfacePoint& a, const SurfacePoint& b) {
                         return a.face == b.face && a.weights == b.weights;
                       }));
  }
}

TEST_CASE("Relax_CancelledByItsCaller_IsAnError") {
  RelaxCase sampled(torus_grid(20, 20), 60, 2);
  CHECK(error_of([&] {
          relax(sampled.scan, sampled.base, 2, {.progress = [](const Progress&) { return false; }},
                sampled.samples);
        }).code() == ErrorCode::kCancelled);
}

}  // namespace plait::test
