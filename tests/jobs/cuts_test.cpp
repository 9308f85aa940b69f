// Where edges are cut into parts: as cheap as any cut allows, by brute force, and for as many parts
// as a store may have.
#include "parts/cuts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "parts/calibrate.h"
#include "plait/base_mesh.h"
#include "plait/extend/edge_index.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

PartCost cost_of_level(int levels) {
  return {.levels = levels, .ns_per_record = 30, .ns_per_point = 8};
}

/// What edges [first, after) cost: their records, and every face at them once.
double cost_of_range(const Topology& mesh, EdgeId first, EdgeId after, const PartCost& cost) {
  double records = 0;
  std::set<FaceId> faces;
  for (EdgeId edge = first; edge < after; ++edge) {
    records += static_cast<double>(cost.records(mesh.edges[edge]));
    for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other})
      if (side.exists()) faces.insert(side.face());
  }
  const double side = static_cast<double>(1u << cost.levels);
  return cost.ns_per_record * records +
         cost.ns_per_point * static_cast<double>(faces.size()) * (side + 1) * (side + 2) / 2;
}

/// What the most expensive part costs at least, for 1, 2, ... parts.
std::vector<double> best_cuts(const Topology& mesh, const PartCost& cost) {
  const auto edges = static_cast<EdgeId>(mesh.edges.size());
  std::vector<std::vector<double>> range(edges, std::vector<double>(edges + 1));
  for (EdgeId first = 0; first < edges; ++first)
    for (EdgeId after = first + 1; after <= edges; ++after)
      range[first][after] = cost_of_range(mesh, first, after, cost);
  std::vector<double> upto = range[0], best;  // upto[after]: of edges [0, after) in so many parts
  upto[0] = 0;
  for (EdgeId parts = 1;; ++parts) {
    best.push_back(upto[edges]);
    if (parts == edges) return best;
    std::vector<double> next(edges + 1, std::numeric_limits<double>::infinity());
    for (EdgeId after = parts + 1; after <= edges; ++after)
      for (EdgeId cut = parts; cut < after; ++cut)
        next[after] = std::min(next[after], std::max(upto[cut], range[cut][after]));
    upto = std::move(next);
  }
}

void require_cuts(const std::vector<EdgeId>& starts, std::size_t parts, std::size_t edges) {
  REQUIRE(starts.size() == parts);
  REQUIRE(starts.front() == 0);
  REQUIRE(starts.back() < edges);
  REQUIRE(std::ranges::adjacent_find(starts, std::greater_equal<>()) == starts.end());
}

}  // namespace

TEST_CASE("CutEdges_IntoAnyNumberOfParts_NoCutHasACheaperWorstPart") {
  const BaseMesh base = BaseMesh::build(random_sheet(7, 10));
  const Topology mesh = base.topology();
  for (const int levels : {1, 4}) {
    const PartCost cost = cost_of_level(levels);
    const std::vector<double> best = best_cuts(mesh, cost);
    for (std::uint32_t parts = 1; parts <= mesh.edges.size(); ++parts) {
      CAPTURE(levels, parts);
      const std::vector<EdgeId> starts = cut_edges(EdgesInMemory(mesh), parts, cost);
      require_cuts(starts, parts, mesh.edges.size());
      double worst = 0;
      for (std::size_t at = 0; at < parts; ++at)
        worst = std::max(
            worst,
            cost_of_range(mesh, starts[at],
                          at + 1 < parts ? starts[at + 1] : static_cast<EdgeId>(mesh.edges.size()),
                          cost));
      CHECK(worst == Approx(best[parts - 1]).epsilon(1e-5));
    }
  }
}

// Most of these parts are cut by number of edges, because two edges cost more than a fair share.
// With a search among all parts for each cut this takes hours.
TEST_CASE("CutEdges_AMillionParts_HaveOneOrTwoEdges") {
  const BaseMesh base = BaseMesh::build(torus_grid(700, 700));
  const Topology mesh = base.topology();
  constexpr std::uint32_t kParts = 1 << 20;
  const std::vector<EdgeId> starts = cut_edges(EdgesInMemory(mesh), kParts, cost_of_level(1));
  require_cuts(starts, kParts, mesh.edges.size());
  EdgeId longest = static_cast<EdgeId>(mesh.edges.size()) - starts.back();
  for (std::size_t at = 1; at < starts.size(); ++at)
    longest = std::max(longest, starts[at] - starts[at - 1]);
  CHECK(longest == 2);
}

// A part of one edge over a large base mesh takes seconds that say nothing of larger parts.
TEST_CASE("RatesOf_AMachineThatTakesTheSameForEachPart_TellItApart") {
  constexpr double kBegin = 0.4, kSame = 0.5, kPointsPerSecond = 3e7, kBytesPerSecond = 4e8;
  const auto trial = [&](double points, double bytes) {
    return Trial{points, bytes, kBegin, kSame + points / kPointsPerSecond, bytes / kBytesPerSecond};
  };
  const MachineRates rates = rates_of(trial(1e6, 4e6), trial(4e7, 2e8));
  CHECK(rates.points_per_second == Approx(kPointsPerSecond));
  CHECK(rates.bytes_per_second == Approx(kBytesPerSecond));
  CHECK(rates.begin_seconds == Approx(kBegin + kSame));
  Trial slowed = trial(1e6, 4e6);
  slowed.compute_seconds = slowed.write_seconds = 100;
  CHECK(rates_of(slowed, trial(4e7, 2e8)).points_per_second <= 4e7 / (kSame / 10));
}

}  // namespace plait::test
