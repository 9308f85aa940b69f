// Blocks that would need more blocks of coarser levels than a block may have: which ones the filter
// hierarchy chooses, and what replaces the vertices of the others, both as
// docs/filters/hierarchy.md says.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "backends/compressed/filters/hierarchy_oracle.h"
#include "backends/compressed/filters/predicted_levels.h"
#include "compressed/filters/built_in_filters.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Block = std::pair<int, std::uint64_t>;  // level, number

constexpr std::size_t kMostBlocks = 16, kMostCounted = 64;

std::uint64_t weight_of(int levels_coarser) {
  if (levels_coarser <= 2) return 32;
  return levels_coarser == 3 ? 16 : levels_coarser == 4 ? 4 : 1;
}

/// The blocks from which a block of `level` is predicted. `needed` becomes how many it would need.
std::set<Block> expected_context(const PredictedLevels<float>& levels, int level,
                                 std::uint64_t block, std::size_t& needed) {
  const Topology mesh = levels.surroundings.mesh;
  const LevelGeometry& own = levels.geometry(level);
  // The edges whose slots are needed, in order, each with its weight.
  std::vector<std::pair<EdgeId, std::uint64_t>> edges;
  const auto add = [&](FaceId face, std::uint64_t weight) {
    for (const EdgeId edge : mesh.face_edges[face]) edges.emplace_back(edge, weight);
  };
  for (EdgeId edge = own.first_edge(block); edge < own.edge_after(block); ++edge)
    for (const FaceSide side : {mesh.edges[edge].own, mesh.edges[edge].other}) {
      if (!side.exists()) continue;
      add(side.face(), 4);
      for (int turn = 1; turn < 3; ++turn) {
        const FaceSide next = mesh.across(FaceSide(side.face(), (side.side() + turn) % 3));
        if (next.exists()) add(next.face(), 1);
      }
    }
  std::set<Block> chosen;
  std::vector<std::tuple<std::uint64_t, int, std::uint64_t>> others;  // weight, level, block
  for (int coarser = 1; coarser < level; ++coarser) {
    const LevelGeometry& geometry = levels.geometry(coarser);
    const std::uint64_t first = geometry.block_of(own.first_edge(block));
    chosen.emplace(coarser, first);
    std::map<std::uint64_t, std::uint64_t> weights;
    for (const auto& [edge, weight] : edges) {
      const std::uint64_t of_edge = geometry.block_of(edge);
      if (of_edge == first || (!weights.contains(of_edge) && weights.size() == kMostCounted))
        continue;
      weights[of_edge] += weight * weight_of(level - coarser);
    }
    for (const auto& [of_edge, weight] : weights) others.emplace_back(weight, coarser, of_edge);
  }
  needed = chosen.size() + others.size();
  std::ranges::sort(others, [](const auto& a, const auto& b) {
    const auto& [weight_a, level_a, block_a] = a;
    const auto& [weight_b, level_b, block_b] = b;
    return std::tuple(weight_b, level_b, block_a) < std::tuple(weight_a, level_a, block_b);
  });
  for (const auto& [weight, coarser, of_edge] : others)
    if (chosen.size() < kMostBlocks) chosen.emplace(coarser, of_edge);
  return chosen;
}

std::set<Block> context_of(const Filter& filter, std::uint64_t block) {
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = filter.context(block, needed);
  std::set<Block> blocks;
  for (std::size_t i = 0; i < count; ++i) blocks.emplace(needed[i].level, needed[i].block);
  return blocks;
}

/// Meshes in an order that no layout has made, so that faces of a block are in many blocks.
std::vector<NamedMesh> scattered_meshes() {
  return {{"sphere", random_sphere(7, 600)}, {"sheet", random_sheet(4, 500)}};
}

}  // namespace

TEST_CASE("HierarchyContext_OfBlocksThatNeedMoreThanTheyMayHave_IsWhatThePageSays") {
  for (const NamedMesh& named : scattered_meshes())
    for (const std::uint64_t block_bytes : {512u, 1024u, 4096u, 16384u}) {
      const PredictedLevels<float> levels(BaseMesh::build(named.mesh), 6, block_bytes);
      std::size_t wrong = 0, full = 0, uncounted = 0;
      for (int level = 1; level <= 6; ++level) {
        const auto filter = make_hierarchy_filter("", levels.filter_level(level));
        for (std::uint64_t block = 0; block < levels.geometry(level).block_count(); ++block) {
          std::size_t needed = 0;
          const std::set<Block> expected = expected_context(levels, level, block, needed);
          wrong += context_of(*filter, block) != expected;
          full += needed > kMostBlocks;
          uncounted += needed > kMostCounted;
        }
      }
      CAPTURE(named.name, block_bytes, full, uncounted);
      CHECK(wrong == 0);
      CHECK(full > 100);
    }
}

TEST_CASE("Hierarchy_VerticesOutsideTheContext_AreReplacedAsThePageSays") {
  for (const NamedMesh& named : scattered_meshes())
    for (const char* rule : {"midpoint", "butterfly", "loop"}) {
      PredictedLevels<float> levels(BaseMesh::build(named.mesh), 4, 4096);
      std::mt19937 random(11);
      std::uniform_real_distribution<float> next(-2, 2);
      levels.fill([&] { return next(random); });
      std::size_t wrong = 0, blocks = 0, count = 0;
      for (int level = 2; level <= 4; ++level) {
        const auto filter = make_hierarchy_filter(rule, levels.filter_level(level));
        const LevelGeometry& own = levels.geometry(level);
        for (std::uint64_t block = 0; block < own.block_count(); block += 5) {
          const FilteredBlock made = encode_and_decode(*filter, levels, level, block);
          CHECK(std::ranges::equal(made.back, levels.block(level, block)));
          const std::set<Block> known = context_of(*filter, block);
          const Oracle<float> oracle(levels, rule, [&](int coarser, EdgeId edge) {
            return known.contains({coarser, levels.geometry(coarser).block_of(edge)});
          });
          const auto* const residuals =
              reinterpret_cast<const std::uint32_t*>(made.filtered.data());
          const auto* const numbers = reinterpret_cast<const float*>(made.back.data());
          const std::int64_t n = slot_side(level);
          std::size_t at = 0;
          for (EdgeId edge = own.first_edge(block); edge < own.edge_after(block); ++edge)
            for (std::int64_t row = 0; row < n; ++row)
              for (std::int64_t column = 0; column < row_records(own.slot(edge).shape, n, row);
                   ++column)
                for (std::size_t k = 0; k < 3; ++k, ++at)
                  wrong +=
                      residuals[at] !=
                      expected_residual(numbers[at], oracle.predict({edge, level, row, column}, k));
          ++blocks;
          count += at;
          CHECK(at * sizeof(float) == made.filtered.size());
        }
      }
      CAPTURE(named.name, rule, blocks, count);
      CHECK(wrong == 0);
    }
}

}  // namespace plait::test
