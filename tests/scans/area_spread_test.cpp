// The spread of areas against areas that are known: those of grids with columns of given widths.
#include "sample/area_spread.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "sample/samples.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr int kLevel = 3;
constexpr std::size_t kSize = 8;

/// Triangle (i, j), and the one beside it, have the area widths[i] heights[j] / 2.
struct Grid {
  std::array<double, kSize> widths, heights;

  std::vector<double> areas() const {
    std::vector<double> result;
    for (std::size_t j = 0; j < kSize; ++j)
      for (std::size_t i = 0; i + j < kSize; ++i)
        result.insert(result.end(), i + j + 1 < kSize ? 2 : 1, widths[i] * heights[j]);
    std::ranges::sort(result);
    return result;
  }
};

Grid even_grid() {
  Grid grid{};
  grid.widths.fill(1);
  grid.heights.fill(1);
  return grid;
}

/// The first column has 15 of the 64 triangles.
Grid grid_of_ratio(double ratio) {
  Grid grid = even_grid();
  grid.widths[0] = 1 / ratio;
  return grid;
}

AreaSpread spread_of(const std::vector<Grid>& grids) {
  const BaseMesh base =
      BaseMesh::build(side_by_side(std::vector<IndexedMesh>(grids.size(), single_triangle())));
  const SampleNumbers numbers(base, kLevel);
  std::vector<Vector3<double>> positions(numbers.count());
  for (FaceId face = 0; face < grids.size(); ++face) {
    double y = 0;
    for (std::size_t j = 0; j <= kSize; ++j) {
      double x = 0;
      for (std::size_t i = 0; i + j <= kSize; ++i) {
        positions[numbers.of(face, static_cast<std::int64_t>(i), static_cast<std::int64_t>(j))] = {
            static_cast<float>(x), static_cast<float>(y), 0};
        if (i < kSize) x += grids[face].widths[i];
      }
      if (j < kSize) y += grids[face].heights[j];
    }
  }
  return area_spread(base, kLevel, positions);
}

}  // namespace

TEST_CASE("AreaSpread_FacesOfKnownRatios_AreCounted") {
  const AreaSpread even = spread_of({even_grid()});
  CHECK(even.percentile_90 == 1);
  CHECK(even.share_within_4 == 1);
  // Eight faces of ratio 2, one of 4, one of 16, and one more of 16.
  std::vector<Grid> grids(8, grid_of_ratio(2));
  grids.push_back(grid_of_ratio(4));
  grids.push_back(grid_of_ratio(16));
  const AreaSpread ten = spread_of(grids);
  CHECK(ten.percentile_90 == 4);
  CHECK(ten.share_within_4 == Approx(0.9));
  grids.push_back(grid_of_ratio(16));
  const AreaSpread eleven = spread_of(grids);
  CHECK(eleven.percentile_90 == 16);
  CHECK(eleven.share_within_4 == Approx(9.0 / 11));
}

TEST_CASE("AreaSpread_OfOneFace_LeavesOutItsLeastAndItsLargestArea", "[threads]") {
  Grid grid = even_grid();
  for (std::size_t at = 0; at < kSize; ++at) {
    grid.widths[at] = 1 + 0.25 * static_cast<double>(at * at);
    grid.heights[at] = 2 - 0.125 * static_cast<double>(at);
  }
  const std::vector<double> areas = grid.areas();
  REQUIRE(areas.size() == 64);
  CHECK(areas[1] > areas[0]);
  CHECK(areas[62] < areas[63]);
  CHECK(spread_of({grid}).percentile_90 == Approx(areas[62] / areas[1]).epsilon(1e-12));
}

TEST_CASE("AreaSpread_TrianglesWithoutArea_GiveANumber") {
  CHECK(spread_of({grid_of_ratio(1e300)}).percentile_90 == 1e12);
  Grid none{};
  const AreaSpread spread = spread_of({none});
  CHECK(spread.percentile_90 == 1e12);
  CHECK(spread.share_within_4 == 0);
}

}  // namespace plait::test
