// BaseMesh::input_maps(): a program finds its own vertices and faces again after all that the
// library does to a mesh.
#include <catch2/catch.hpp>
#include <utility>

#include "plait/base_mesh.h"
#include "plait/layout.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

/// A mesh with unused vertices at its beginning, inside and at its end, and with turned faces.
IndexedMesh untidy() {
  const IndexedMesh clean = random_sheet(5, 60);
  IndexedMesh mesh;
  mesh.positions.push_back({-1, -1, -1});
  for (std::size_t v = 0; v < clean.positions.size(); ++v) {
    if (v == 11) mesh.positions.push_back({-2, -2, -2});
    mesh.positions.push_back(clean.positions[v]);
  }
  mesh.positions.push_back({-3, -3, -3});
  for (const auto& face : clean.faces) {
    auto& corners = mesh.faces.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) corners[i] = face[i] + (face[i] >= 11 ? 2 : 1);
  }
  for (std::size_t face = 1; face < mesh.faces.size(); face += 5)
    std::swap(mesh.faces[face][1], mesh.faces[face][2]);
  return mesh;
}

void check_maps(const BaseMesh& mesh, const IndexedMesh& input) {
  const InputMaps maps = mesh.input_maps();
  REQUIRE(maps.input_vertices.size() == mesh.vertex_count());
  REQUIRE(maps.input_vertex_count == input.positions.size());
  REQUIRE(maps.vertices.size() == input.positions.size());
  for (VertexId vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    REQUIRE(mesh.positions()[vertex] == input.positions[maps.input_vertices[vertex]]);
    REQUIRE(maps.vertices[maps.input_vertices[vertex]] == vertex);
  }
  REQUIRE(maps.faces.size() == input.faces.size());
  for (FaceId face = 0; face < mesh.face_count(); ++face) {
    auto corners = input.faces[maps.input_faces[face]];
    if (maps.turned[face]) std::swap(corners[1], corners[2]);
    for (std::size_t i = 0; i < 3; ++i)
      REQUIRE(maps.input_vertices[mesh.faces()[face][i]] == corners[i]);
    REQUIRE(maps.faces[maps.input_faces[face]] == face);
  }
}

}  // namespace

TEST_CASE("InputMaps_OfAnUntidyMesh_LeadToEachVertexAndFaceAndBack") {
  const IndexedMesh input = untidy();
  const BaseMesh built = BaseMesh::build(input);
  CHECK(built.differs_from_input());
  check_maps(built, input);
  for (const LayoutKind kind : {LayoutKind::kGiven, LayoutKind::kSpatial, LayoutKind::kHilbert,
                                LayoutKind::kRcm, LayoutKind::kAutomatic}) {
    const BaseMesh laid_out = lay_out(built, kind).mesh;
    check_maps(laid_out, input);
    check_maps(lay_out(laid_out, LayoutKind::kSpatial).mesh, input);
  }
  const InputMaps maps = built.input_maps();
  for (const VertexId unused : {VertexId{0}, VertexId{12}}) CHECK(maps.vertices[unused] == kNoId);
  CHECK(maps.vertices.back() == kNoId);
}

TEST_CASE("InputMaps_OfATidyMesh_TakeNoMemory") {
  const BaseMesh mesh = BaseMesh::build(random_sphere(3, 60));
  CHECK_FALSE(mesh.differs_from_input());
  check_maps(mesh, random_sphere(3, 60));
}

TEST_CASE("WithInputMaps_WrongMaps_AreRefused") {
  const BaseMesh mesh = BaseMesh::build(random_sphere(3, 60));
  const auto with = [&](const auto& change) {
    InputMaps maps = mesh.input_maps();
    change(maps);
    return error_of([&] { return BaseMesh(mesh).with_input_maps(maps); });
  };
  using E = ErrorCode;
  CHECK(with([](InputMaps& maps) { maps.input_vertices.pop_back(); }).code() ==
        E::kInvalidArgument);
  CHECK(with([](InputMaps& maps) { maps.turned.pop_back(); }).code() == E::kInvalidArgument);
  CHECK(with([](InputMaps& maps) { maps.input_vertices[3] = 1 << 30; }).code() ==
        E::kInvalidArgument);
  CHECK(with([](InputMaps& maps) { maps.input_faces[3] = 1 << 30; }).code() == E::kInvalidArgument);
}
