#include "sample/samples.h"

#include <catch2/catch.hpp>
#include <set>

#include "support/test_meshes.h"

namespace plait::test {

TEST_CASE("SampleNumbers_EveryMesh_NameEachVertexOnce") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const BaseMesh base = BaseMesh::build(named.mesh);
    for (const int level : {0, 1, 2, 3}) {
      const SampleNumbers numbers(base, level);
      CHECK(numbers.count() == counts_at_level(base, level).vertices);
      // The flat position of a vertex follows from every face that has it.
      const Point nowhere{1e9, 1e9, 1e9};
      std::vector<Point> places(numbers.count(), nowhere);
      std::size_t differences = 0;
      const auto size = static_cast<double>(numbers.size());
      for (FaceId face = 0; face < base.face_count(); ++face) {
        const auto& [a, b, c] = base.faces()[face];
        for (std::int64_t j = 0; j <= numbers.size(); ++j)
          for (std::int64_t i = 0; i + j <= numbers.size(); ++i) {
            const double u = static_cast<double>(i) / size, v = static_cast<double>(j) / size;
            const Point p = (1 - u - v) * base.positions()[a] + u * base.positions()[b] +
                            v * base.positions()[c];
            Point& place = places.at(numbers.of(face, i, j));
            if (place == nowhere)
              place = p;
            else if (length(place - p) > 1e-9)
              ++differences;
          }
      }
      CHECK(differences == 0);
      CHECK(std::count(places.begin(), places.end(), nowhere) == 0);
    }
  }
}

TEST_CASE("SampleNumbers_TrianglesOfFace_CoverIt") {
  const BaseMesh base = BaseMesh::build(single_triangle());
  const SampleNumbers numbers(base, 3);
  std::set<std::set<std::uint64_t>> triangles;
  numbers.for_each_triangle(0, [&](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    triangles.insert({a, b, c});
  });
  CHECK(triangles.size() == 64);
}

}  // namespace plait::test
