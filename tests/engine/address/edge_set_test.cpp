#include "plait/detail/edge_set.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "plait/error.h"

namespace plait {

TEST_CASE("EdgeSet_RandomEdges_AgreesWithCounting") {
  std::mt19937 random(1);
  for (const EdgeId edge_count : {1u, 63u, 64u, 65u, 128u, 1000u})
    for (const unsigned percent : {0u, 2u, 50u, 100u}) {
      std::vector<EdgeId> edges;
      for (EdgeId edge = 0; edge < edge_count; ++edge)
        if (random() % 100 < percent) edges.push_back(edge);
      const EdgeSet set(edges);
      REQUIRE(set.size() == edges.size());
      REQUIRE(set.empty() == edges.empty());
      REQUIRE(set.end() == (edges.empty() ? 0 : edges.back() + 1));
      std::uint64_t rank = 0;
      for (EdgeId edge = 0; edge < edge_count + 200; ++edge) {
        REQUIRE(set.rank(edge) == rank);
        const bool member = std::ranges::binary_search(edges, edge);
        REQUIRE(set.contains(edge) == member);
        rank += member ? 1 : 0;
      }
      CHECK(set.rank(~std::uint64_t{0}) == edges.size());
    }
}

TEST_CASE("EdgeSet_Empty_TakesNoMemory") {
  CHECK(EdgeSet().memory_bytes() == 0);
  CHECK(EdgeSet(std::vector<EdgeId>()).memory_bytes() == 0);
  const std::vector<EdgeId> edges = {0, 640};
  CHECK(EdgeSet(edges).memory_bytes() == 11 * 16);
}

TEST_CASE("EdgeSet_Copies_OutliveTheOriginal") {
  EdgeSet copy;
  {
    const std::vector<EdgeId> edges = {3, 70};
    const EdgeSet original(edges);
    copy = original;
  }
  CHECK(copy.rank(70) == 1);
  CHECK(copy.contains(70));
}

TEST_CASE("EdgeSet_EdgesThatDoNotAscend_AreRefused") {
  for (const std::vector<EdgeId>& edges : {std::vector<EdgeId>{2, 1}, {1, 1}, {0, 5, 5, 7}}) {
    try {
      EdgeSet{edges};
      FAIL("accepted");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::kInvalidArgument);
    }
  }
}

}  // namespace plait
