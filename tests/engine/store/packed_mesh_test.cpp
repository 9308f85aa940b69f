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
    const std::vector<std::byte> packed = pack_mesh(mesh);
    REQUIRE(packed.size() == packed_mesh_bytes(mesh.vertex_count(), mesh.face_count()));
    const auto back = unpack_mesh(packed, mesh.vertex_count(), mesh.face_count());
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
  const std::vector<std::byte> packed = pack_mesh(mesh);
  std::vector<int> expected;
  const auto planes = [&](const std::vector<std::uint64_t>& numbers, int bytes) {
    for (int plane = 0; plane < bytes; ++plane)
      for (const std::uint64_t number : numbers)
        expected.push_back(static_cast<int>(number >> (8 * plane) & 255));
  };
  constexpr std::uint64_t kOne = 0x3ff0000000000000;
  planes({kOne, 0, 0, kOne}, 8);
  planes({0, kOne, 0, kOne}, 8);
  planes({0, 0, kOne, 0}, 8);
  planes({0, 0, 0, 3, 2, 0}, 4);
  planes({4, 3, 2, 4}, 4);
  std::vector<int> found;
  for (const std::byte byte : packed) found.push_back(std::to_integer<int>(byte));
  CHECK(found == expected);
}

TEST_CASE("PackedMesh_AnyBytes_AreAMeshWhoseFacesUseVerticesOrNothing") {
  std::mt19937 random(1);
  int meshes = 0;
  for (int run = 0; run < 20000; ++run) {
    const std::uint64_t vertices = random() % 6, faces = random() % 5;
    std::vector<std::byte> packed(packed_mesh_bytes(vertices, faces));
    // Few different low bytes, so that some are meshes.
    for (std::size_t i = 24 * vertices; i < packed.size(); ++i) {
      const bool low = i < 24 * vertices + 3 * faces ||
                       (i >= 24 * vertices + 12 * faces && i < 25 * vertices + 12 * faces);
      if (low) packed[i] = static_cast<std::byte>(random() % 7);
    }
    const auto mesh = unpack_mesh(packed, vertices, faces);
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
