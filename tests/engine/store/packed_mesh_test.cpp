// The packed form of a base mesh: what docs/format.md says, and its inverse.
#include "format/packed_mesh.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

#include "support/test_meshes.h"

namespace plait::test {

TEST_CASE("PackedMesh_AnyMesh_ComesBack") {
  for (const NamedMesh& named : all_meshes()) {
    CAPTURE(named.name);
    const BaseMesh mesh = BaseMesh::build(named.mesh);
    const PositionWords words = words_of(mesh.positions());
    const std::vector<std::byte> packed = pack_mesh(mesh, words);
    REQUIRE(packed.size() == packed_mesh_bytes(mesh.vertex_count(), mesh.face_count(), words));
    const auto back = unpack_mesh(packed, mesh.vertex_count(), mesh.face_count(), words);
    REQUIRE(back);
    CHECK(std::ranges::equal(back->faces, mesh.faces()));
    REQUIRE(back->positions.size() == mesh.vertex_count());
    CHECK(std::memcmp(back->positions.data(), mesh.positions().data(),
                      mesh.positions().size_bytes()) == 0);
  }
}

TEST_CASE("PackedMesh_OfTwoFaces_HasTheBytesOfThePage") {
  const BaseMesh mesh = BaseMesh::build(
      {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}}, {{2, 0, 1}, {1, 0, 3}}}, "two faces");
  const std::vector<std::byte> packed =
      pack_mesh(mesh, {.form = PositionForm::kFloat64, .exponent = 0});
  std::vector<int> expected;
  const auto planes = [&](const std::vector<std::uint64_t>& numbers, int bytes) {
    for (int plane = 0; plane < bytes; ++plane)
      for (const std::uint64_t number : numbers)
        expected.push_back(static_cast<int>(number >> (8 * plane) & 255));
  };
  planes({0, 0, 0, 3, 2, 0}, 4);
  planes({4, 3, 2, 4}, 4);
  // Vertices 2, 0, 1, 3. The place of 0 is the sign bit alone; 2 d of 2^63 leaves nothing.
  constexpr std::uint64_t kOne = 0x3ff0000000000000, kZero = std::uint64_t{1} << 63;
  const auto places = [&](std::initializer_list<std::uint64_t> bits) {
    std::vector<std::uint64_t> differences;
    std::uint64_t before = 0;
    for (const std::uint64_t number : bits) {
      const std::uint64_t place = number + kZero, d = place - before;
      differences.push_back(d < kZero ? 2 * d : 2 * (0 - d) - 1);
      before = place;
    }
    planes(differences, 8);
  };
  places({0, kOne, 0, kOne});
  places({0, 0, kOne, kOne});
  places({kOne, 0, 0, 0});
  std::vector<int> found;
  for (const std::byte byte : packed) found.push_back(std::to_integer<int>(byte));
  CHECK(found == expected);
}

TEST_CASE("PositionWords_AreTheSmallestThatGiveTheBitsAgain") {
  const auto words = [](std::vector<Vector3<double>> positions) {
    const PositionWords found = words_of(positions);
    const BaseMesh mesh = BaseMesh::build({positions, {{0, 1, 2}}}, "a face");
    const auto back = unpack_mesh(pack_mesh(mesh, found), 3, 1, found);
    REQUIRE(back);
    CHECK(std::memcmp(back->positions.data(), positions.data(), 72) == 0);
    return found;
  };
  const auto is = [](PositionWords found, PositionForm form, int exponent) {
    return found.form == form && found.exponent == exponent;
  };
  CHECK(is(words({{0, 0, 0}, {0.25, 3, -5}, {7, 1, 2}}), PositionForm::kWhole, -2));
  CHECK(is(words({{0, 0, 0}, {1024, 0, 0}, {0, -2048, 0}}), PositionForm::kWhole, 10));
  CHECK(is(words({{0, 0, 0}, {0x1p-24, 0, 0}, {0, 0.5, 0}}), PositionForm::kWhole, -24));
  // Too many of them, and -0, which is no whole number.
  CHECK(is(words({{0, 0, 0}, {0x1p-24, 0, 0}, {0, 1, 0}}), PositionForm::kFloat32, 0));
  CHECK(is(words({{-0.0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), PositionForm::kFloat32, 0));
  CHECK(is(words({{0.1F, 0, 0}, {1, 0, 1e30F}, {0, 1e-40F, 0}}), PositionForm::kFloat32, 0));
  CHECK(is(words({{0.1, 0, 0}, {1, 0, 0}, {0, 1e300, 5e-324}}), PositionForm::kFloat64, 0));
  CHECK(is(words({{0, 0, 0}, {0x1p950, 0, 0}, {0, 0x1p950, 0}}), PositionForm::kFloat64, 0));
  CHECK(is(words({{0, 0, 0}, {0x1p-1050, 0, 0}, {0, 0x1p-1050, 0}}), PositionForm::kFloat64, 0));
}

TEST_CASE("PackedMesh_AnyBytes_AreAMeshWhoseFacesUseVerticesOrNothing") {
  std::mt19937 random(1);
  int meshes = 0;
  for (int run = 0; run < 20000; ++run) {
    const std::uint64_t vertices = random() % 6, faces = random() % 5;
    const PositionWords words{static_cast<PositionForm>(1 + run % 3), 0};
    std::vector<std::byte> packed(packed_mesh_bytes(vertices, faces, words));
    // Few different low bytes, so that some are meshes.
    for (std::size_t i = 0; i < 12 * faces + vertices; ++i)
      if (i < 3 * faces || i >= 12 * faces) packed[i] = static_cast<std::byte>(random() % 7);
    const auto mesh = unpack_mesh(packed, vertices, faces, words);
    if (!mesh) continue;
    ++meshes;
    REQUIRE(mesh->positions.size() == vertices);
    REQUIRE(mesh->faces.size() == faces);
    for (const auto& face : mesh->faces)
      for (const VertexId vertex : face) REQUIRE(vertex < vertices);
  }
  CHECK(meshes > 100);
}

}  // namespace plait::test
