// Import: a level that a store exports, shuffled, comes back as the same base mesh with the same
// bits at every vertex.
#include "plait/extend/import_mesh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "plait/error.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/error_of.h"
#include "support/parallel_loops.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;
using Point = Vector3<float>;
using Bits = std::array<std::uint32_t, 3>;

Bits bits_of(const Point& point) {
  Bits bits;
  std::memcpy(bits.data(), &point, sizeof bits);
  return bits;
}

Store loop_store(const IndexedMesh& mesh, int levels) {
  Store store =
      Store::create({}, BaseMesh::build(mesh),
                    {.backend = "memory", .durability = Durability::kNone}, default_backends());
  add_base_positions(store);
  subdivide(store, {.levels = levels});
  return store;
}

/// The finest level as triangles.
IndexedMesh triangles_of(const Store& store) {
  const int level = store.finest_level();
  const VertexNumbering numbering(store.base().topology(), level);
  IndexedMesh mesh;
  mesh.positions.resize(numbering.vertex_count());
  const Reader reader(store);
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const PatchView patch = reader.read_patch(face, level);
    const auto position = patch.attribute<Point>("position");
    const auto number = [&](const FacePoint& at) {
      return static_cast<VertexId>(numbering.number({face, level, at.i, at.j}));
    };
    for_each_triangle(level, [&](const std::array<FacePoint, 3>& corners) {
      std::array<VertexId, 3>& triangle = mesh.faces.emplace_back();
      for (std::size_t at = 0; at < 3; ++at) {
        triangle[at] = number(corners[at]);
        const Point& p = position.at(corners[at].i, corners[at].j);
        mesh.positions[triangle[at]] = {p.x, p.y, p.z};
      }
    });
  }
  return mesh;
}

/// The patches of a level: for the corners of each face, from the one with the smallest bits on,
/// the records in row order.
std::map<std::array<Bits, 3>, std::vector<Bits>> patches_of(const Store& store, int level) {
  std::map<std::array<Bits, 3>, std::vector<Bits>> patches;
  const Reader reader(store);
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const PatchView patch = reader.read_patch(face, level);
    const auto position = patch.attribute<Point>("position");
    const std::int64_t size = position.size();
    const std::array<Bits, 3> corners = {bits_of(position.at(0, 0)), bits_of(position.at(size, 0)),
                                         bits_of(position.at(0, size))};
    const auto turn = std::ranges::min_element(corners) - corners.begin();
    std::array<Bits, 3> key = corners;
    std::ranges::rotate(key, key.begin() + turn);
    std::vector<Bits>& records = patches[key];
    for (std::int64_t j = 0; j <= size; ++j)
      for (std::int64_t i = 0; i + j <= size; ++i) {
        const std::array<std::int64_t, 3> turned = {size - i - j, i, j};
        const auto weight = [&](std::ptrdiff_t corner) {
          return turned[static_cast<std::size_t>((corner + 3 - turn) % 3)];
        };
        records.push_back(bits_of(position.at(weight(1), weight(2))));
      }
  }
  return patches;
}

struct Files {
  TemporaryDirectory directory{Medium::kMemory};
  fs::path mesh = directory.path() / "fine.ply", store = directory.path() / "s.plait";

  ImportRequest request() const {
    return {.mesh = mesh,
            .store = store,
            .block_bytes = 4096,
            .budget_bytes = 1 << 20,
            .threads = 2,
            .durability = Durability::kNone};
  }
  Store open() const { return Store::open(store, {}, default_backends()); }
  bool left_nothing() const {
    return std::distance(fs::directory_iterator(directory.path()), fs::directory_iterator()) == 1;
  }
};

}  // namespace

TEST_CASE("ImportMesh_ShuffledLevel_IsTheStoreThatItCameFrom") {
  const int levels = GENERATE(1, 2, 3, 4);
  unsigned seed = 0;
  for (const NamedMesh& each : all_meshes()) {
    if (each.mesh.faces.size() << 2 * levels > 60000) continue;
    INFO(each.name << ", " << levels << " levels");
    const Store original = loop_store(each.mesh, levels);
    const Files files;
    write_ply(files.mesh, shuffled(triangles_of(original), ++seed));
    ImportRequest request = files.request();
    request.levels = levels;
    request.max_slot_bytes = 1 << 20;
    const ImportResult result = import_mesh(request, default_backends());
    CHECK(result.levels == levels);
    CHECK(result.base_level == 0);
    const Store store = files.open();
    CHECK(store.base().vertex_count() == original.base().vertex_count());
    CHECK(store.base().face_count() == original.base().face_count());
    CHECK(store.base().border_edge_count() == original.base().border_edge_count());
    if (!result.had_choice) CHECK(patches_of(store, levels) == patches_of(original, levels));
  }
}

TEST_CASE("ImportMesh_FewerLevelsOrSmallSlots_AreAFinerBaseMesh") {
  const Store original = loop_store(icosahedron(), 4);
  const Files files;
  write_ply(files.mesh, shuffled(triangles_of(original), 5));
  ImportRequest request = files.request();
  SECTION("fewer levels") {
    request.levels = 3;
    const ImportResult result = import_mesh(request, default_backends());
    CHECK(result.levels == 3);
    CHECK(files.open().base().face_count() == 80);
    CHECK(result.next_level.empty());
  }
  SECTION("all levels, in small slots") {
    request.max_slot_bytes = 48;
    const ImportResult result = import_mesh(request, default_backends());
    CHECK(result.levels == 4);
    CHECK(result.base_level == 2);
    CHECK(result.next_level.find("found 4 levels") != std::string::npos);
    const Store store = files.open();
    CHECK(store.base().face_count() == 320);
    CHECK(store.base_level() == 2);
    CHECK(store.finest_level() == 4);
  }
  SECTION("more levels than there are") {
    request.levels = 5;
    const Error error = error_of([&] { import_mesh(request, default_backends()); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    for (const char* const word : {"fine.ply", "found 4 levels", "vertex", "5 faces", "remesh"})
      CHECK(std::string(error.what()).find(word) != std::string::npos);
    CHECK(files.left_nothing());
  }
}

TEST_CASE("ImportMesh_FacesOfBothOrientations_AgreeWithTheFirst") {
  const Store original = loop_store(random_sphere(3, 60), 2);
  const Files files, turned;
  IndexedMesh mesh = shuffled(triangles_of(original), 5);
  write_ply(files.mesh, mesh);
  for (std::size_t face = 1; face < mesh.faces.size(); face += 3)
    std::swap(mesh.faces[face][1], mesh.faces[face][2]);
  write_ply(turned.mesh, mesh);
  std::vector<std::string> warnings;
  const JobWatch watch{.warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  import_mesh(files.request(), default_backends(), watch);
  CHECK(warnings.empty());
  import_mesh(turned.request(), default_backends(), watch);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("flipped") != std::string::npos);
  CHECK(patches_of(turned.open(), 2) == patches_of(files.open(), 2));
}

TEST_CASE("ImportMesh_Pipelines_ArePredictedInTheEnd") {
  const Store original = loop_store(random_sphere(3, 60), 3);
  const Files files;
  write_ply(files.mesh, shuffled(triangles_of(original), 5));
  ImportRequest request = files.request();
  request.levels = 3;
  request.pipeline_of = [](const AttributeSchema&) { return LevelPipelines("hierarchy,bitpack"); };
  import_mesh(request, default_backends());
  CHECK(patches_of(files.open(), 3) == patches_of(original, 3));
}

TEST_CASE("ImportMesh_EveryCancelledPhase_LeavesNothing") {
  const Files files;
  write_ply(files.mesh, triangles_of(loop_store(octahedron(), 3)));
  std::vector<std::string> phases;
  JobWatch watch;
  watch.progress = [&](const Progress& now) {
    if (phases.empty() || phases.back() != now.phase) phases.emplace_back(now.phase);
    return true;
  };
  import_mesh(files.request(), default_backends(), watch);
  CHECK(phases ==
        std::vector<std::string>{"read", "connect", "levels", "lay out", "write", "commit"});
  fs::remove_all(files.store);
  for (const std::string& phase : phases) {
    watch.progress = [&](const Progress& now) { return now.phase != phase; };
    const Error error = error_of([&] { import_mesh(files.request(), default_backends(), watch); });
    CHECK(error.code() == ErrorCode::kCancelled);
    CHECK(files.left_nothing());
  }
}

TEST_CASE("ImportMesh_OnThePoolOfTheProgram_WritesTheSamePatchesAndStops") {
  const Files files;
  const Store original = loop_store(random_sphere(3, 400), 3);
  write_ply(files.mesh, triangles_of(original));
  for (const NamedLoop& pool : parallel_loops()) {
    CAPTURE(pool.name);
    fs::remove_all(files.store);
    std::atomic<int> bodies = 0;
    ImportRequest request = files.request();
    request.levels = 3;
    request.parallel_for = [&](int count, const std::function<void(int)>& body) {
      bodies += count;
      pool.loop(count, body);
    };
    import_mesh(request, default_backends());
    CHECK(bodies == request.threads);
    CHECK(patches_of(files.open(), 3) == patches_of(original, 3));
    fs::remove_all(files.store);
    JobWatch watch;
    watch.progress = [](const Progress& now) { return now.phase != "write" || now.done == 0; };
    CHECK(error_of([&] { import_mesh(request, default_backends(), watch); }).code() ==
          ErrorCode::kCancelled);
    CHECK(files.left_nothing());
  }
}

TEST_CASE("ImportMesh_WithMoreThreadsThanTheBudgetHolds_TakesFewerAndSaysSo") {
  const Store original = loop_store(icosahedron(), 5);
  const Files files;
  write_ply(files.mesh, shuffled(triangles_of(original), 5));
  ImportRequest request = files.request();
  request.max_slot_bytes = 1 << 20;
  std::vector<std::string> warnings;
  const JobWatch watch{.warn = [&](const std::string& warning) { warnings.push_back(warning); }};
  import_mesh(request, default_backends(), watch);
  CHECK(warnings.empty());
  const auto expected = patches_of(files.open(), 5);
  fs::remove_all(files.store);
  request.threads = 200;
  import_mesh(request, default_backends(), watch);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("threads of 200") && Catch::Contains("budget"));
  CHECK(patches_of(files.open(), 5) == expected);
}

TEST_CASE("ImportMesh_WhatIsNoManifold_IsRefusedByName") {
  const Files files;
  const auto refused = [&](const IndexedMesh& mesh, const std::string& words) {
    write_ply(files.mesh, mesh);
    const Error error = error_of([&] { import_mesh(files.request(), default_backends()); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(std::string(error.what()).find(words) != std::string::npos);
    CHECK(files.left_nothing());
  };
  IndexedMesh mesh = octahedron();
  mesh.faces[3] = {1, 1, 2};
  refused(mesh, "face 3");
  mesh = octahedron();
  mesh.faces.push_back(mesh.faces[0]);
  refused(mesh, "face");
  refused({{{0, 0, 0}}, {}}, "at least one face");
  // Places in shuffled files have the names that BaseMesh::build() gives them.
  const IndexedMesh level = triangles_of(loop_store(icosahedron(), 2));
  for (unsigned seed = 1; seed < 8; ++seed) {
    IndexedMesh broken = level;
    const VertexId apex = broken.faces[50][0], start = broken.faces[50][1];
    broken.positions.push_back({3, 0, 0});
    broken.positions.push_back({3, 1, 0});
    const auto end = static_cast<VertexId>(broken.positions.size() - 1);
    if (seed % 2 == 0)
      broken.faces.push_back({apex, start, end});  // an edge of three faces
    else
      broken.faces.push_back({apex, end - 1, end});  // two fans at a vertex
    broken = shuffled(broken, seed);
    const Error expected = error_of([&] { BaseMesh::build(broken, files.mesh.native()); });
    refused(broken, expected.what());
  }
  ImportRequest request = files.request();
  write_ply(files.mesh, triangles_of(loop_store(octahedron(), 1)));
  request.backend = "memory";
  CHECK(error_of([&] { import_mesh(request, default_backends()); }).code() ==
        ErrorCode::kInvalidArgument);
  request.mesh = files.directory.path() / "none.ply";
  request.backend = "pread";
  CHECK(error_of([&] { import_mesh(request, default_backends()); }).code() == ErrorCode::kNotFound);
}

}  // namespace plait::test
