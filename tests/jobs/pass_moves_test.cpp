// Passes that move vertices: how far, which way, in which waves, and with the same bits for every
// backend, layout, block size and number of threads.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "passes/gradient_noise.h"
#include "passes/vertex_noise.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/pass.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/visit_vertices.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

struct Displacement {
  std::string kind = "noise";
  double amplitude = 3e-7;
  std::uint64_t seed = 1;
  int threads = 1;
  ProgressCallback progress = {};
};

/// Normals, if there are any, are made anew.
PassFigures displace(Store& store, const Displacement& how) {
  return run_pass(store,
                  {.name = how.kind,
                   .amplitude = how.amplitude,
                   .seed = how.seed,
                   .remakes_normals = store.has_attribute("normal")},
                  {.threads = how.threads, .progress = how.progress});
}

struct DisplacedShape {
  std::string backend = "memory";
  std::uint64_t block_bytes = 4096;
  LayoutKind layout = LayoutKind::kGiven;
  bool normals = true, wide = false;
};

Store refined_store(const std::filesystem::path& path, const IndexedMesh& mesh, int levels,
                    const DisplacedShape& shape = {}) {
  const StoreOptions options{
      .backend = shape.backend, .durability = Durability::kNone, .block_bytes = shape.block_bytes};
  Store store = Store::create(path, lay_out(BaseMesh::build(mesh), shape.layout).mesh, options,
                              default_backends());
  add_base_positions(store, shape.wide ? ComponentType::kFloat64 : ComponentType::kFloat32);
  subdivide(store, {.executor = ExecutorKind::kSweep, .levels = levels, .normals = shape.normals});
  return store;
}

/// All records of an attribute, level by level in the order of their numbers.
template <class Record>
std::vector<Record> records_of(Store& store, const char* attribute) {
  std::vector<std::vector<Record>> levels;
  visit_vertices(store, {}, std::tuple{reads<Record>(attribute)},
                 [&](const VertexRun& run, std::span<const Record> records) {
                   const auto level = static_cast<std::size_t>(run.level);
                   if (levels.size() <= level) levels.resize(level + 1);
                   if (levels[level].size() < run.first + run.count)
                     levels[level].resize(run.first + run.count);
                   std::ranges::copy(
                       records, levels[level].begin() + static_cast<std::ptrdiff_t>(run.first));
                 });
  std::vector<Record> all;
  for (const auto& level : levels) all.insert(all.end(), level.begin(), level.end());
  return all;
}

template <class Real>
struct Extent {
  Vector3<Real> low, high;
  double diagonal;
};
template <class Real>
Extent<Real> extent(const std::vector<Vector3<Real>>& points) {
  Vector3<Real> low = points[0], high = points[0];
  for (const auto& point : points)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], point[axis]);
      high[axis] = std::max(high[axis], point[axis]);
    }
  const double x = double(high.x) - low.x, y = double(high.y) - low.y, z = double(high.z) - low.z;
  return {low, high, std::hypot(x, y, z)};
}

using Wide = Vector3<double>;

}  // namespace

TEST_CASE("RandomWord_IsSplitMix64") {
  // The first results for state 1234567, as the generator's author publishes them.
  const std::vector<std::uint64_t> expected = {6457827717110365317u, 3203168211198807973u,
                                               9817491932198370423u, 4593380528125082431u,
                                               16408922859458223821u};
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(random_word(1234567, i) == expected[i]);
  CHECK(from_minus_one_to_one(0) == -1);
  CHECK(from_minus_one_to_one(~std::uint64_t{0}) == 1 - 0x1p-52);
  CHECK(slot_key(1, 5, 9, 2) == slot_key(1, 9, 5, 2));
  CHECK(slot_key(1, 5, 9, 2) != slot_key(1, 5, 9, 3));
  CHECK(slot_key(1, 5, 9, 2) != slot_key(2, 5, 9, 2));
}

TEST_CASE("Moves_ShorterThanTheStepsOfTheirType_AreCounted") {
  IndexedMesh far = random_sphere(3, 30);
  for (Vector3<double>& p : far.positions) p = 100.0 * p + Vector3<double>{5e6, 5e6, 5e6};
  for (const bool wide : {false, true}) {
    Store store = refined_store({}, far, 3, {.normals = false, .wide = wide});
    const std::uint64_t vertices = counts_at_level(store.base(), 3).vertices;
    const PassFigures noise = displace(store, {.amplitude = 1e-5, .seed = 11});
    CHECK(noise.rounded_moves == (wide ? 0 : vertices));
    // The steps of float32 there are 0.5, and half of them is more than any way.
    if (!wide) CHECK(noise.largest_move == 0);
    CHECK(displace(store, {.amplitude = 0.1, .seed = 11}).rounded_moves < vertices / 10);
  }
}

TEST_CASE("Noise_MovesEachCoordinateUniformlyWithinTheAmplitude") {
  Store store = refined_store({}, random_sphere(3, 300), 4, {.normals = false, .wide = true});
  const std::vector<Wide> before = records_of<Wide>(store, "position");
  const double amplitude = 0.01, bound = amplitude * extent(before).diagonal;
  const PassFigures displaced = displace(store, {.amplitude = amplitude, .seed = 11});
  const std::vector<Wide> after = records_of<Wide>(store, "position");
  CHECK(displaced.diagonal == Approx(extent(before).diagonal).epsilon(1e-14));
  REQUIRE(after.size() == before.size());
  const double count = double(after.size());
  REQUIRE(count > 30000);
  double largest = 0, longest = 0;
  Wide sum{}, squares{}, products{};
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Wide way = after[i] - before[i];
    for (int axis = 0; axis < 3; ++axis) {
      largest = std::max(largest, std::abs(way[axis]));
      sum[axis] += way[axis] / bound;
      squares[axis] += way[axis] * way[axis] / (bound * bound);
      products[axis] += way[axis] * way[(axis + 1) % 3] / (bound * bound);
    }
    longest = std::max(longest, std::sqrt(dot(way, way)));
  }
  CHECK(largest <= bound * (1 + 1e-12));
  CHECK(largest > 0.999 * bound);
  CHECK(displaced.largest_move == Approx(longest).epsilon(1e-9));
  // Five standard deviations of a uniform distribution.
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(std::abs(sum[axis] / count) < 5 * std::sqrt(1.0 / 3 / count));
    CHECK(squares[axis] / count == Approx(1.0 / 3).margin(5 * std::sqrt(4.0 / 45 / count)));
    CHECK(std::abs(products[axis] / count) < 5 * std::sqrt(1.0 / 9 / count));
  }
}

TEST_CASE("Noise_OfAVertex_FollowsFromItsEdgeLevelAndPlace") {
  Store store = refined_store({}, tetrahedron(), 3, {.normals = false, .wide = true});
  std::vector<std::vector<Wide>> before, after;
  const auto slots = [&](std::vector<std::vector<Wide>>& to) {
    visit_vertices(store, {}, std::tuple{reads<Wide>("position")},
                   [&](const VertexRun&, std::span<const Wide> records) {
                     to.emplace_back(records.begin(), records.end());
                   });
  };
  slots(before);
  const double scale = 0.25 * displace(store, {.amplitude = 0.25, .seed = 5}).diagonal;
  slots(after);
  std::size_t slot = 0, wrong = 0;
  const auto word = [](std::uint64_t state, std::uint64_t steps) {
    state += 0x9e3779b97f4a7c15u * (steps + 1);
    state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9u;
    state = (state ^ state >> 27) * 0x94d049bb133111ebu;
    return state ^ state >> 31;
  };
  const auto check = [&](std::uint64_t start, std::uint64_t end, std::uint64_t level,
                         const Wide& from, const Wide& to, std::uint64_t place) {
    const std::uint64_t key =
        word(word(word(5, 0), std::min(start, end) << 32 | std::max(start, end)), level);
    for (int axis = 0; axis < 3; ++axis) {
      const double u = double(word(key, 3 * place + std::uint64_t(axis)) >> 11) / 0x1p53;
      wrong += std::abs(to[axis] - from[axis] - scale * (2 * u - 1)) > 1e-12;
    }
  };
  for (const Edge& edge : store.base().edges())
    for (std::uint64_t level = 1; level <= 3; ++level, ++slot)
      for (std::size_t i = 0; i < before[slot].size(); ++i)
        check(edge.start, edge.end, level, before[slot][i], after[slot][i], i);
  for (std::size_t vertex = 0; vertex < before[slot].size(); ++vertex)
    check(vertex, vertex, 0, before[slot][vertex], after[slot][vertex], 0);
  CHECK(before[slot].size() == 4);
  CHECK(wrong == 0);
}

TEST_CASE("Displace_BackendsBlocksThreadsAndLayouts_GiveTheSameBits") {
  const IndexedMesh mesh = random_sheet(7, 200);
  for (const std::string kind : {"noise", "fractal"}) {
    std::string expected;
    const auto check = [&](const DisplacedShape& shape, int threads) {
      CAPTURE(kind, shape.backend, threads);
      const TemporaryDirectory directory(Medium::kMemory);
      Store store = refined_store(shape.backend == "memory" ? "" : directory.path() / "s.plait",
                                  mesh, 4, shape);
      displace(store, {.kind = kind, .amplitude = 0.003, .seed = 42, .threads = threads});
      store.commit();
      const std::string found = digest(store).to_string();
      if (expected.empty()) expected = found;
      CHECK(found == expected);
    };
    check({}, 1);
    check({}, 3);
    check({.backend = "memory", .block_bytes = 1 << 16, .layout = LayoutKind::kHilbert}, 2);
    check({.backend = "pread", .layout = LayoutKind::kRcm}, 2);
    check({.backend = "mmap"}, 1);
    check({.backend = "compressed"}, 2);
    // The bits of the first version, on every machine.
    CHECK(expected == (kind == "noise" ? "9ceff9ce45064585cab12028d0d5bb00"
                                       : "2fc4a8f2e34bf624fd6677f902962b94"));
  }
}

TEST_CASE("Displace_Normals_AreThoseOfTheScheme") {
  for (const IndexedMesh& mesh : {random_sphere(5, 80), random_sheet(6, 80), open_fan(7)})
    for (const bool wide : {false, true}) {
      Store store = refined_store({}, mesh, 3, {.wide = wide});
      const std::string before = digest(store).to_string();
      // No vertex moves, so every normal must come out as subdivide() made it.
      displace(store, {.amplitude = 0});
      CHECK(digest(store).to_string() == before);
      displace(store, {.amplitude = 1e-3, .seed = 2});
      CHECK(digest(store).to_string() != before);
      for (const auto& normal : records_of<Vector3<float>>(store, "normal"))
        if (std::abs(dot(normal, normal) - 1) > 1e-5f) FAIL("a normal has another length");
    }
}

TEST_CASE("GradientNoise_IsZeroOnTheLatticeAndBoundedBetween") {
  double least = 0, most = 0, sum = 0;
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 40; ++j)
      for (int k = 0; k < 40; ++k) {
        if (gradient_noise({double(i - 20), double(j - 20), double(k - 20)}, 3) != 0)
          FAIL("not zero on the lattice");
        const double value = gradient_noise({0.37 * i - 7, 0.41 * j - 8, 0.43 * k - 9}, 3);
        least = std::min(least, value);
        most = std::max(most, value);
        sum += value;
      }
  CHECK(least >= -1);
  CHECK(most <= 1);
  CHECK(most > 0.6);
  CHECK(least < -0.6);
  CHECK(std::abs(sum / 64000) < 0.01);
  CHECK(gradient_noise({0.2, 0.4, 0.7}, 3) != gradient_noise({0.2, 0.4, 0.7}, 4));
  // Continuous across the cells' sides, also at negative coordinates.
  for (const double x : {-3.0, 0.0, 5.0})
    CHECK(gradient_noise({x - 1e-9, 0.3, -0.6}, 9) ==
          Approx(gradient_noise({x + 1e-9, 0.3, -0.6}, 9)).margin(1e-8));
}

TEST_CASE("GradientNoise_AlongALine_HasHardlyAnyWavesShorterThanHalfAStep") {
  constexpr int kSamples = 1024, kPerStep = 8;
  const Wide along{0.48 / kPerStep, 0.6 / kPerStep, 0.64 / kPerStep};
  double slow = 0, fast = 0;
  for (const std::uint64_t key : {1u, 2u, 3u, 4u}) {
    std::vector<double> values;
    for (int i = 0; i < kSamples; ++i) values.push_back(gradient_noise(double(i) * along, key));
    for (int frequency = 1; frequency <= kSamples / 2; ++frequency) {
      double real = 0, imaginary = 0;
      for (int i = 0; i < kSamples; ++i) {
        // A window, so that the ends of the line are no step.
        const double window = 1 - std::cos(2 * std::numbers::pi * i / kSamples);
        const double angle = 2 * std::numbers::pi * frequency * i / kSamples;
        real += window * values[std::size_t(i)] * std::cos(angle);
        imaginary += window * values[std::size_t(i)] * std::sin(angle);
      }
      const double steps = double(kSamples) / frequency / kPerStep;
      (steps < 0.5 ? fast : slow) += real * real + imaginary * imaginary;
    }
  }
  CHECK(fast < 0.003 * slow);
}

TEST_CASE("Fractal_MovesAlongTheNormalsInWavesFromTheDiagonalToTheEdges") {
  Store store = refined_store({}, random_sphere(3, 300), 4, {.wide = true});
  const std::vector<Wide> before = records_of<Wide>(store, "position");
  const std::vector<Vector3<float>> normals = records_of<Vector3<float>>(store, "normal");
  double edges = 0, count = 0;
  visit_vertices(store, {}, std::tuple{rings_of<Wide>("position")},
                 [&](const VertexRun& run, const VertexRings<Wide>& ring) {
                   for (std::size_t i = 0; i < run.count; ++i)
                     for (int k = 0; k < ring.valence(); ++k, ++count) {
                       const Wide edge = ring.neighbour(i, k) - ring.vertex(i);
                       edges += std::hypot(edge.x, edge.y, edge.z);
                     }
                 });
  const double amplitude = 0.01;
  const PassFigures displaced =
      displace(store, {.kind = "fractal", .amplitude = amplitude, .seed = 8});
  const auto [low, high, diagonal] = extent(before);
  const double edge = edges / count;
  CHECK(displaced.mean_edge == Approx(edge).epsilon(1e-6));
  REQUIRE(displaced.wavelengths.size() >= 2);
  CHECK(displaced.wavelengths.front() == displaced.diagonal / 8);
  CHECK(displaced.wavelengths.back() >= 4 * edge);
  CHECK(displaced.wavelengths.back() < 8 * edge);

  const std::vector<Wide> after = records_of<Wide>(store, "position");
  double largest = 0, sum = 0, wrong = 0, sideways = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    const Wide way = after[i] - before[i];
    const Wide normal{normals[i].x, normals[i].y, normals[i].z};
    const double height = dot(way, normal);
    const Wide aside = cross(way, normal);
    double expected = 0, part = amplitude * diagonal;
    for (std::size_t octave = 0; octave < displaced.wavelengths.size(); ++octave, part *= 0.45)
      expected += part * gradient_noise((1 / displaced.wavelengths[octave]) * (before[i] - low),
                                        random_word(8, octave));
    wrong = std::max(wrong, std::abs(height - expected));
    sideways = std::max(sideways, std::sqrt(dot(aside, aside)));
    largest = std::max(largest, std::abs(height));
    sum += height;
  }
  const double unit = amplitude * diagonal;
  CHECK(wrong < 1e-6 * unit);
  CHECK(sideways < 1e-6 * unit);
  CHECK(largest <= unit / 0.55);
  CHECK(largest > 0.5 * unit);
  CHECK(std::abs(sum / double(after.size())) < 0.1 * unit);
}

TEST_CASE("Displace_ForgetsTheScheme") {
  Store store = refined_store({}, octahedron(), 2);
  REQUIRE(store.provenance().scheme == "loop");
  Provenance limit = store.provenance();
  limit.limit = true;
  StoreAccess::set_provenance(store, limit);
  const AttributeId normal = store.attribute("normal");
  StoreAccess::set_rounding(store, normal, Rounding{});
  displace(store, {});
  CHECK(store.provenance().scheme.empty());
  CHECK_FALSE(store.provenance().limit);
  CHECK_FALSE(StoreAccess::rounding(store, store.attribute("normal")));  // they were made anew
  CHECK(store.attributes().size() == 2);
  CHECK(store.has_attribute("position"));
}

TEST_CASE("Displace_WhatCannotBe_IsRefusedBeforeAnyChange") {
  const auto refuses = [](Store& store, const Displacement& options, const std::string& says,
                          ErrorCode code = ErrorCode::kInvalidArgument) {
    const std::size_t attributes = store.attributes().size();
    const Error error = error_of([&] { displace(store, options); });
    CHECK(error.code() == code);
    CHECK_THAT(error.what(), Catch::Contains(says));
    CHECK(store.attributes().size() == attributes);
    CHECK_NOTHROW(store.commit());
  };
  Store store = refined_store({}, octahedron(), 3);
  refuses(store, {.amplitude = -1}, "amplitude -1, expected 0 to 1");
  refuses(store, {.amplitude = std::numeric_limits<double>::quiet_NaN()}, "amplitude nan");
  refuses(store, {.threads = -1}, "-1 threads");
  Store coarse = refined_store({}, octahedron(), 1);
  refuses(coarse, {.kind = "fractal"}, "refine the mesh further");
  Store point = refined_store({}, octahedron(), 2);
  visit_vertices(point, {}, std::tuple{updates<Vector3<float>>("position")},
                 [](const VertexRun&, std::span<Vector3<float>> at) {
                   std::ranges::fill(at, Vector3<float>{1, 2, 3});
                 });
  refuses(point, {}, "no extent");
  visit_vertices(point, {}, std::tuple{updates<Vector3<float>>("position")},
                 [](const VertexRun& run, std::span<Vector3<float>> at) {
                   if (run.level == 2) at.back().y = std::numeric_limits<float>::quiet_NaN();
                 });
  refuses(point, {}, "not finite");
  Store unlike = refined_store({}, octahedron(), 2, {.normals = false});
  unlike.add_attribute(schema_of<Vector3<double>>("normal"), 2);
  refuses(unlike, {}, "makes 'normal' with float32 x 3, and the store has float64 x 3");
  Store bare =
      Store::create({}, BaseMesh::build(octahedron()), {.backend = "memory"}, default_backends());
  refuses(bare, {}, "position", ErrorCode::kNotFound);
}

TEST_CASE("Displace_Watched_CountsToTheEndAndStopsWhenTold") {
  for (const std::string kind : {"noise", "fractal"}) {
    Store store = refined_store({}, random_sphere(3, 20), 5);
    std::uint64_t last = 0, all = 0, calls = 0;
    std::vector<std::string> phases;
    Displacement options;
    options.kind = kind;
    options.progress = [&](const Progress& now) {
      if (phases.empty() || phases.back() != now.phase) {
        CHECK(last == all);
        phases.emplace_back(now.phase);
        last = 0;
      }
      CHECK(now.done > last);
      last = now.done;
      all = now.total;
      ++calls;
      return true;
    };
    displace(store, options);
    CHECK(last == all);
    CHECK(phases == (kind == "noise" ? std::vector<std::string>{"bounding box", "noise", "normals"}
                                     : std::vector<std::string>{"bounding box", "mean edge",
                                                                "fractal", "normals"}));
    options.progress = [calls](const Progress&) mutable { return --calls > 1; };
    CHECK(error_of([&] { displace(store, options); }).code() == ErrorCode::kCancelled);
    CHECK(error_of([&] { store.commit(); }).code() == ErrorCode::kBadState);
  }
}
