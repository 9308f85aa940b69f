// Relaxed samples follow the scan more closely, and keep what they must.
#include "sample/relax.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "collapse/decimate.h"
#include "distance/distances.h"
#include "sample/exact_faces.h"
#include "sample/turned.h"
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
  /// `mesh` is over a square of the plane with the given side. The base mesh has four cells, and
  /// the samples are even in the plane.
  RelaxCase(const IndexedMesh& mesh, double side)
      : scan(repair(mesh, {}, "mesh").surface), level(3) {
    IndexedMesh coarse = sheet(2, 2);
    for (Point& p : coarse.positions) p = {side / 2 * p.x, side / 2 * p.y, 0};
    base = BaseMesh::build(coarse);
    const SampleNumbers numbers(base, level);
    samples.resize(numbers.count());
    const auto size = static_cast<double>(numbers.size());
    for (FaceId face = 0; face < base.face_count(); ++face) {
      const auto& [a, b, c] = base.faces()[face];
      for (std::int64_t j = 0; j <= numbers.size(); ++j)
        for (std::int64_t i = 0; i + j <= numbers.size(); ++i) {
          const double u = static_cast<double>(i) / size, v = static_cast<double>(j) / size;
          samples[numbers.of(face, i, j)] =
              above((1 - u - v) * base.positions()[a] + u * base.positions()[b] +
                    v * base.positions()[c]);
        }
    }
  }
  /// The point of the scan that is above a point of the plane.
  SurfacePoint above(Point at) const {
    SurfacePoint best;
    double least = -1;
    for (FaceId face = 0; face < scan.faces.size(); ++face) {
      std::array<Point, 3> corners = {scan.corner(face, 0), scan.corner(face, 1),
                                      scan.corner(face, 2)};
      for (Point& p : corners) p.z = 0;
      const double whole = area_vector(corners[0], corners[1], corners[2]).z;
      const double u = area_vector(corners[0], at, corners[2]).z / whole,
                   v = area_vector(corners[0], corners[1], at).z / whole;
      const double smallest = std::min({1 - u - v, u, v});
      if (best.face != kNoId && smallest <= least) continue;
      least = smallest;
      best = {face, {1 - u - v, u, v}};
    }
    for (double& weight : best.weights) weight = std::max(weight, 0.0);
    return best;
  }

  std::uint64_t relax(const RelaxOptions& options = {}) {
    return plait::relax(scan, base, level, options, samples);
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

/// Over all small triangles, with the normals and mean areas that relax() promises to look at.
struct Limits {
  double most_ratio = 1;    ///< of an area and the mean one of its base face before
  double least_cosine = 1;  ///< between a normal and the scan's
};

std::vector<Point> normals_of(const Surface& scan) {
  std::vector<Point> normals(scan.positions.size());
  for (FaceId face = 0; face < scan.faces.size(); ++face)
    for (const VertexId vertex : scan.faces[face])
      normals[vertex] = normals[vertex] + area_vector(scan.corner(face, 0), scan.corner(face, 1),
                                                      scan.corner(face, 2));
  for (Point& normal : normals) normal = normalized(normal);
  return normals;
}

Limits limits_of(const RelaxCase& now, const RelaxCase& before) {
  const std::vector<Point> normals = normals_of(now.scan);
  const auto normal_at = [&](const SurfacePoint& at) {
    const auto& [a, b, c] = now.scan.faces[at.face];
    return normalized(at.weights[0] * normals[a] + at.weights[1] * normals[b] +
                      at.weights[2] * normals[c]);
  };
  const auto normal_of = [](const IndexedMesh& mesh, std::size_t face) {
    const auto& [a, b, c] = mesh.faces[face];
    return area_vector(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
  };
  const IndexedMesh old = before.small_triangles(), small = now.small_triangles();
  const std::size_t count = std::size_t{1} << (2 * now.level);
  Limits limits;
  for (std::size_t first = 0; first < small.faces.size(); first += count) {
    double mean = 0;
    for (std::size_t i = first; i < first + count; ++i)
      mean += length(normal_of(old, i)) / static_cast<double>(count);
    for (std::size_t i = first; i < first + count; ++i) {
      const Point normal = normal_of(small, i);
      const double ratio = length(normal) / mean;
      limits.most_ratio = std::max({limits.most_ratio, ratio, 1 / ratio});
      Point expected{0, 0, 0};
      for (const VertexId sample : small.faces[i])
        expected = expected + normal_at(now.samples[sample]);
      limits.least_cosine = std::min(limits.least_cosine,
                                     dot(normal, expected) / (length(normal) * length(expected)));
    }
  }
  return limits;
}

/// A sheet with a ridge of a given height and width.
IndexedMesh ridge(double height, double width) {
  IndexedMesh mesh = sheet(40, 40);
  for (Point& p : mesh.positions) {
    const double across = (p.x - 17.3) / width;
    p.z = height * std::exp(-across * across);
  }
  return mesh;
}

/// A sheet with one ridge beside the other.
IndexedMesh ridges(double height, double width) {
  IndexedMesh mesh = sheet(40, 40);
  for (Point& p : mesh.positions) {
    const double across = std::remainder(p.x - 17.3 + 0.3 * (p.y - 22.1), 11.0) / width;
    p.z = height * std::exp(-across * across);
  }
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

TEST_CASE("Relax_RoundsAfterTheFullOnes_MoveFewerSamplesAndComeCloser") {
  for (const IndexedMesh& mesh : {torus_grid(60, 40), waves()}) {
    const RelaxCase first(mesh, 60, 3);
    RelaxCase full = first, later = first, all = first;
    full.relax({.rounds = 3, .full_rounds = 3});
    later.relax({.rounds = 10, .full_rounds = 3});
    all.relax({.rounds = 10, .full_rounds = 10});
    const auto moved_since = [&](const RelaxCase& other) {
      std::size_t count = 0;
      for (std::size_t i = 0; i < full.samples.size(); ++i)
        count += full.samples[i].face != other.samples[i].face ||
                         full.samples[i].weights != other.samples[i].weights
                     ? 1u
                     : 0u;
      return count;
    };
    CHECK(moved_since(later) > 0);
    CHECK(2 * moved_since(later) < moved_since(all));
    CHECK(later.distance() < full.distance());
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
      const TriangleTree tree(sampled.scan.positions, sampled.scan.faces);
      const std::vector<std::uint8_t> exact =
          exact_faces(sampled.scan, tree, sampled.base, level, sampled.samples);
      const std::uint64_t moved = sampled.relax({.still_faces = exact});
      // Beside a triangle that is turned already, another may turn.
      CHECK(count_turned(sampled.scan, sampled.base, level, sampled.samples) <=
            turned + turned / 50);
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

TEST_CASE("Relax_AreasWithinTheLimit_StayWithinIt") {
  for (const double height : {2.0, 4.0, 8.0}) {
    const RelaxCase first(ridges(height, 3), 40);
    REQUIRE(limits_of(first, first).most_ratio < 1.9);
    RelaxCase limited = first, other = first;
    limited.relax();
    CHECK(limits_of(limited, first).most_ratio < 2 + 1e-9);
    other.relax({.most_ratio = 1e9});  // the limit was at work
    CHECK(limits_of(other, first).most_ratio > 3);
  }
}

TEST_CASE("Relax_NormalsNearTheScans_StayNear") {
  for (const double width : {1.5, 3.0}) {
    const RelaxCase first(ridge(16, width), 40);
    REQUIRE(limits_of(first, first).least_cosine > 0.4);
    RelaxCase relaxed = first;
    CHECK(relaxed.relax() > 0);
    CHECK(limits_of(relaxed, first).least_cosine > 0.3 - 1e-9);
  }
}

TEST_CASE("Relax_AnyNumberOfThreads_GivesTheSameBits", "[threads]") {
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

TEST_CASE("Relax_CancelledByItsCaller_IsAnError", "[threads]") {
  RelaxCase sampled(torus_grid(20, 20), 60, 2);
  CHECK(error_of([&] {
          relax(sampled.scan, sampled.base, 2, {.progress = [](const Progress&) { return false; }},
                sampled.samples);
        }).code() == ErrorCode::kCancelled);
}

TEST_CASE("ExactFaces_OfASheetThatIsFlatOnOneSide_AreThoseOfThatSideAndStay", "[threads]") {
  IndexedMesh mesh = sheet(40, 40);
  for (Point& p : mesh.positions) p.z = p.x > 20 ? 0.5 * std::sin(p.x - 20) * std::sin(p.y) : 0;
  RelaxCase sampled(mesh, 40);
  const TriangleTree tree(sampled.scan.positions, sampled.scan.faces);
  const std::vector<std::uint8_t> exact =
      exact_faces(sampled.scan, tree, sampled.base, sampled.level, sampled.samples);
  for (FaceId face = 0; face < sampled.base.face_count(); ++face) {
    double most = 0;
    for (const VertexId vertex : sampled.base.faces()[face])
      most = std::max(most, sampled.base.positions()[vertex].x);
    CHECK(exact[face] == (most <= 20 ? 1 : 0));
  }
  const auto before = sampled.samples;
  CHECK(sampled.relax({.still_faces = exact}) > 0);
  for (std::size_t sample = 0; sample < before.size(); ++sample)
    if (position_of(sampled.scan, before[sample]).x <= 20)
      CHECK(sampled.samples[sample].weights == before[sample].weights);
  sampled.samples = before;
  sampled.relax();
  std::size_t moved = 0;
  for (std::size_t sample = 0; sample < before.size(); ++sample)
    if (position_of(sampled.scan, before[sample]).x <= 20)
      moved += sampled.samples[sample].weights != before[sample].weights ? 1u : 0u;
  CHECK(moved > 0);
}

TEST_CASE("Relax_Progress_IsToldWithinARound") {
  RelaxCase sampled(torus_grid(40, 40), 100, 3);
  std::uint64_t calls = 0, before = 0, falls = 0;
  const auto count = [&](const Progress& now) {
    ++calls;
    falls += now.done < before || now.done > now.total;
    before = now.done;
    return calls < 40;
  };
  CHECK(error_of([&] {
          sampled.relax({.rounds = 1, .full_rounds = 1, .progress = count});
        }).code() == ErrorCode::kCancelled);
  CHECK(falls == 0);
  CHECK(before > 0);
}

}  // namespace plait::test
