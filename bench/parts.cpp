// What do single parts cost: an index transform, sealing a block? Each part has a floor: for a
// transform a table with the results, as a mesh that stores its indices would have it; for sealing,
// copying the bytes.
//
//   plait_bench_parts [--benchmark_filter=REGEX] [--benchmark_format=console|json|csv]
//
// The options are those of Google Benchmark. It prints median, mean and deviation of five
// repetitions.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <random>
#include <vector>

#include "plait/base_mesh.h"
#include "plait/block_table.h"
#include "plait/edge_index.h"
#include "support.h"

namespace {

using namespace plait;

constexpr int kLevel = 6;
// Few enough for the caches, so that only arithmetic is measured.
constexpr std::int64_t kPoints = 4096;
constexpr std::int64_t kBlockBytes = std::int64_t{1} << 20;

const BaseMesh& mesh() {
  static const BaseMesh base = bench::octahedron(4);
  return base;
}

/// Points of random faces, none of them a corner.
const std::vector<FaceIndex>& face_points() {
  static const std::vector<FaceIndex> points = [] {
    std::mt19937 random(1);
    const auto below = [&](std::int64_t count) {
      return std::uniform_int_distribution<std::int64_t>(0, count - 1)(random);
    };
    std::vector<FaceIndex> made;
    while (std::ssize(made) < kPoints) {
      const std::int64_t i = below((1 << kLevel) + 1), j = below((1 << kLevel) + 1 - i);
      const auto face = static_cast<FaceId>(below(static_cast<std::int64_t>(mesh().face_count())));
      if (!is_corner(kLevel, i, j)) made.push_back({face, kLevel, i, j});
    }
    return made;
  }();
  return points;
}

const std::vector<EdgeIndex>& edge_points() {
  static const std::vector<EdgeIndex> points = [] {
    std::vector<EdgeIndex> made;
    for (const FaceIndex& point : face_points())
      made.push_back(edge_index(mesh().topology(), point));
    return made;
  }();
  return points;
}

void count_points(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * kPoints);
}

void face_index_to_edge_index(benchmark::State& state) {
  const Topology topology = mesh().topology();
  for ([[maybe_unused]] auto turn : state)
    for (const FaceIndex& point : face_points())
      benchmark::DoNotOptimize(edge_index(topology, point));
  count_points(state);
}

void edge_index_to_face_index(benchmark::State& state) {
  const Topology topology = mesh().topology();
  for ([[maybe_unused]] auto turn : state)
    for (const EdgeIndex& point : edge_points())
      benchmark::DoNotOptimize(face_index(topology, point));
  count_points(state);
}

void index_from_a_table(benchmark::State& state) {
  for ([[maybe_unused]] auto turn : state)
    for (const EdgeIndex& point : edge_points()) {
      EdgeIndex found = point;
      benchmark::DoNotOptimize(found);
    }
  count_points(state);
}

void count_bytes(benchmark::State& state) {
  state.SetBytesProcessed(state.iterations() * kBlockBytes);
}

void seal_a_block(benchmark::State& state) {
  const std::vector<std::byte> block(kBlockBytes, std::byte{1});
  BlockTable table(StoreUuid{}, 0, kLevel, 1);
  for ([[maybe_unused]] auto turn : state) {
    table.seal(0, 0, BlockEncoding::kRaw, block);
    benchmark::ClobberMemory();
  }
  count_bytes(state);
}

void copy_a_block(benchmark::State& state) {
  const std::vector<std::byte> block(kBlockBytes, std::byte{1});
  std::vector<std::byte> copy(kBlockBytes);
  for ([[maybe_unused]] auto turn : state) {
    std::memcpy(copy.data(), block.data(), copy.size());
    benchmark::ClobberMemory();
  }
  count_bytes(state);
}

BENCHMARK(face_index_to_edge_index)->Repetitions(5)->ReportAggregatesOnly();
BENCHMARK(edge_index_to_face_index)->Repetitions(5)->ReportAggregatesOnly();
BENCHMARK(index_from_a_table)->Repetitions(5)->ReportAggregatesOnly();
BENCHMARK(seal_a_block)->Repetitions(5)->ReportAggregatesOnly();
BENCHMARK(copy_a_block)->Repetitions(5)->ReportAggregatesOnly();

}  // namespace

BENCHMARK_MAIN();
