// Random meshes of two kinds: grown meshes, whose topology is known; and random triangles, which a
// naive and obviously correct definition accepts or refuses.

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "plait/base_mesh.h"
#include "shapes.h"

using namespace plait;

namespace {

using Random = std::mt19937;
using Face = std::array<VertexId, 3>;

std::size_t below(Random& random, std::size_t bound) { return random() % bound; }

/// A torus with some faces divided into three, which gives vertices of valence 3 and higher, and
/// with holes where faces that share no vertex are removed. Then faces and vertices are shuffled,
/// faces are rotated, and some are flipped. `holes` receives the number of holes.
IndexedMesh grow_mesh(Random& random, std::size_t& holes) {
  IndexedMesh mesh = shapes::torus(static_cast<VertexId>(3 + below(random, 6)),
                                   static_cast<VertexId>(3 + below(random, 6)));
  auto vertices = static_cast<VertexId>(mesh.positions.size());
  for (std::size_t splits = below(random, 100); splits > 0; --splits) {
    Face& face = mesh.faces[below(random, mesh.faces.size())];
    const Face old = face;
    const VertexId middle = vertices++;
    face = {old[0], old[1], middle};
    mesh.faces.push_back({old[1], old[2], middle});
    mesh.faces.push_back({old[2], old[0], middle});
  }
  // After a hole is made, no face at its corners can become another hole. So two holes never touch.
  std::vector<bool> used(vertices, false);
  holes = 0;
  for (std::size_t tries = below(random, 20); tries > 0; --tries) {
    const std::size_t at = below(random, mesh.faces.size());
    const Face face = mesh.faces[at];
    if (std::any_of(face.begin(), face.end(), [&](VertexId v) { return used[v]; })) continue;
    for (const Face& other : mesh.faces)
      if (std::any_of(face.begin(), face.end(), [&](VertexId v) {
            return std::find(other.begin(), other.end(), v) != other.end();
          }))
        for (const VertexId v : other) used[v] = true;
    mesh.faces.erase(mesh.faces.begin() + static_cast<std::ptrdiff_t>(at));
    ++holes;
  }

  std::vector<VertexId> relabel(vertices);
  std::iota(relabel.begin(), relabel.end(), 0);
  std::shuffle(relabel.begin(), relabel.end(), random);
  std::shuffle(mesh.faces.begin(), mesh.faces.end(), random);
  const bool flips = below(random, 2) == 0;
  for (Face& face : mesh.faces) {
    for (VertexId& vertex : face) vertex = relabel[vertex];
    std::rotate(face.begin(), face.begin() + below(random, 3), face.end());
    if (flips && below(random, 4) == 0) std::swap(face[1], face[2]);
  }
  mesh.positions = shapes::with_any_positions(vertices, {}).positions;
  return mesh;
}

bool contains(const Face& face, VertexId vertex) {
  return std::find(face.begin(), face.end(), vertex) != face.end();
}

/// Whether the faces at a vertex are connected across edges at that vertex. Grows a set from one
/// face.
bool has_one_fan(const std::vector<Face>& faces, VertexId vertex) {
  std::vector<Face> apart;
  std::copy_if(faces.begin(), faces.end(), std::back_inserter(apart),
               [&](const Face& face) { return contains(face, vertex); });
  if (apart.empty()) return true;
  std::vector<Face> fan = {apart.back()};
  apart.pop_back();
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t i = 0; i < apart.size() && !grown; ++i)
      for (const Face& member : fan) {
        int shared = 0;
        for (const VertexId v : member) shared += contains(apart[i], v) ? 1 : 0;
        if (shared < 2) continue;
        fan.push_back(apart[i]);
        apart.erase(apart.begin() + static_cast<std::ptrdiff_t>(i));
        grown = true;
        break;
      }
  }
  return apart.empty();
}

bool is_oriented(const std::vector<Face>& faces, unsigned flips) {
  std::set<std::pair<VertexId, VertexId>> directed;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    Face face = faces[f];
    if (flips >> f & 1u) std::swap(face[1], face[2]);
    for (std::size_t side = 0; side < 3; ++side)
      if (!directed.insert({face[side], face[(side + 1) % 3]}).second) return false;
  }
  return true;
}

bool is_manifold_by_definition(const std::vector<Face>& faces, VertexId vertices) {
  std::map<std::pair<VertexId, VertexId>, int> uses;
  std::set<Face> rotated;
  for (Face face : faces) {
    for (std::size_t side = 0; side < 3; ++side) {
      const auto [low, high] = std::minmax(face[side], face[(side + 1) % 3]);
      if (low == high || ++uses[{low, high}] > 2) return false;
    }
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    if (!rotated.insert(face).second) return false;
  }
  for (VertexId vertex = 0; vertex < vertices; ++vertex)
    if (!has_one_fan(faces, vertex)) return false;
  for (unsigned flips = 0; flips < 1u << faces.size(); ++flips)
    if (is_oriented(faces, flips)) return true;
  return false;
}

}  // namespace

TEST_CASE("BaseMeshBuild_GrownMeshes_KeepEveryTopologicalRelation") {
  Random random(20240501);
  for (int round = 0; round < 300; ++round) {
    std::size_t holes = 0;
    const IndexedMesh input = grow_mesh(random, holes);
    INFO("round " << round);
    const BaseMesh mesh = BaseMesh::build(input);
    shapes::check_topology(mesh);
    REQUIRE(mesh.vertex_count() == input.positions.size());
    REQUIRE(mesh.border_edge_count() == 3 * holes);
    REQUIRE(shapes::euler_number(mesh) == -static_cast<std::int64_t>(holes));
    for (std::size_t face = 0; face < input.faces.size(); ++face)
      REQUIRE(mesh.faces()[face][0] == input.faces[face][0]);

    std::vector<FaceId> order(mesh.face_count());
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    shapes::check_topology(mesh.with_face_order(order));
  }
}

TEST_CASE("BaseMeshBuild_TriangleSoups_AreAcceptedExactlyIfManifold") {
  Random random(7);
  int accepted = 0, refused = 0;
  for (int round = 0; round < 20000; ++round) {
    const auto vertices = static_cast<VertexId>(4 + below(random, 4));
    std::vector<Face> faces(1 + below(random, 7));
    for (Face& face : faces)
      for (VertexId& vertex : face) vertex = static_cast<VertexId>(below(random, vertices));
    const bool expected = is_manifold_by_definition(faces, vertices);
    bool found = true;
    try {
      const BaseMesh mesh = BaseMesh::build(shapes::with_any_positions(vertices, faces));
      shapes::check_topology(mesh);
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::kInvalidArgument);
      found = false;
    }
    INFO("round " << round);
    REQUIRE(found == expected);
    ++(found ? accepted : refused);
  }
  CHECK(accepted > 500);
  CHECK(refused > 500);
}
