// Stores whose faces have depths of their own: which records they keep, what is drawn of them, how
// far that is from all levels, and who refuses them.
#include "prune/prune.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "conversion/conversion_job.h"
#include "distance/closest_point.h"
#include "export/numbered_triangles.h"
#include "export/vertex_stream.h"
#include "jobs/pruned_stores.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/check_store.h"
#include "plait/extend/pass.h"
#include "plait/extend/store_access.h"
#include "plait/job.h"
#include "plait/notes.h"
#include "plait/patch_writer.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "prune/compare_pruned.h"
#include "support/error_of.h"
#include "support/sanitized.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::prune_test {
namespace {

/// How often each undirected edge is a side of a triangle; nothing if a directed one is twice.
std::optional<std::map<std::pair<std::uint64_t, std::uint64_t>, int>> edges_of(
    const PatchSelection& patches) {
  std::set<std::pair<std::uint64_t, std::uint64_t>> directed;
  std::map<std::pair<std::uint64_t, std::uint64_t>, int> edges;
  bool once = true;
  std::uint64_t triangles = 0;
  for_each_numbered_triangle(
      patches,
      [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        ++triangles;
        for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
          once &= from != to && directed.insert({from, to}).second;
          ++edges[std::minmax(from, to)];
        }
      },
      [](std::uint64_t) {});
  if (!once || triangles != patches.triangle_count()) return std::nullopt;
  return edges;
}

}  // namespace

TEST_CASE("Prune_ByAFaceAttribute_KeepsTheBitsOfWhatIsLeft") {
  std::mt19937 random(42);
  const std::vector<IndexedMesh> meshes = {tetrahedron(),        seven_vertex_torus(),
                                           open_fan(5),          two_components(),
                                           random_sphere(3, 40), random_sheet(4, 40)};
  for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh)
    for (const int balance : {0, 1}) {
      CAPTURE(mesh, balance);
      const TemporaryDirectory directory;
      const std::uint64_t faces = BaseMesh::build(meshes[mesh]).face_count();
      const std::vector<std::uint8_t> depths = random_depths(faces, random, kLevels);
      const auto from = whole_store(directory.path() / "whole", meshes[mesh], depths);
      const auto to = directory.path() / "pruned";
      const PruneResult result = pruned(from, to, balance);
      const Store whole = open(from), store = open(to);
      if (balance == 0) CHECK(result.raised == 0);
      std::uint64_t raised = 0;
      for (FaceId face = 0; face < faces; ++face) {
        raised += store.depth(face) != depths[face] ? 1u : 0u;
        CHECK(store.depth(face) >= depths[face]);
      }
      CHECK(raised == result.raised);

      const PrunedComparison compared = compare_pruned(store, whole);
      CHECK(compared.difference.value_or("") == "");
      // Two attributes, whose records are all that the edges have.
      CHECK(compared.records == 2 * counts_at_level(store.base(), kLevels).vertices);
      CHECK(result.copy.vertices == counts_at_level(store.base(), kLevels).vertices);

      const Reader reader(store);
      for (FaceId face = 0; face < faces; ++face) {
        const int depth = reader.depth(face);
        for (int level = 0; level <= depth; ++level)
          CHECK(std::memcmp(patch_of(store, face, level).data(),
                            patch_of(whole, face, level).data(),
                            sizeof(Position) * patch_vertex_count(std::int64_t{1} << level)) == 0);
        CHECK(reader.read_patch(face, Depth::kOwn).level() == depth);
        if (depth < store.finest_level())
          CHECK(code_of([&] { reader.read_patch(face, depth + 1); }) ==
                ErrorCode::kInvalidArgument);
        for (int side = 0; side < 3; ++side) {
          const FaceSide beyond = store.base().topology().across(FaceSide(face, side));
          const std::optional<int> across = reader.depth_across(face, side);
          CHECK(across.has_value() == beyond.exists());
          if (!across) continue;
          CHECK(*across == store.depth(beyond.face()));
          if (balance == 1) CHECK(std::abs(*across - depth) <= 1);
        }
      }
      CHECK(verify(store).damaged.empty());
    }
}

TEST_CASE("Prune_WithEqualDepths_GivesTheStoreOfTheseLevels") {
  const TemporaryDirectory directory;
  const IndexedMesh mesh = random_sphere(5, 30);
  const std::uint64_t faces = BaseMesh::build(mesh).face_count();
  const auto from =
      whole_store(directory.path() / "whole", mesh, std::vector<std::uint8_t>(faces, kLevels));
  const auto to = directory.path() / "pruned";
  pruned(from, to, 1);
  CHECK(digest(open(to)) == digest(open(from)));
  CHECK(counts_at_level(open(to).base(), 2).edges == counts_at_level(open(from).base(), 2).edges);
}

TEST_CASE("Drawn_OfRandomDepths_HasNoGapAndTheEulerNumberOfTheBaseMesh") {
  std::mt19937 random(7);
  int patterns = 0;
  // Numbers of vertices tell edges apart only where no two faces have two sides in common.
  for (const NamedMesh& named : all_meshes()) {
    const BaseMesh base = BaseMesh::build(named.mesh);
    if (base.face_count() > 200) continue;
    for (int turn = 0; turn < unless_sanitized(40, 5); ++turn, ++patterns) {
      CAPTURE(named.name, turn);
      const BaseMesh deep = base.with_depths(random_depths(base.face_count(), random, 4));
      const int level = static_cast<int>(random() % 5);
      const PatchSelection patches(deep, level, all_faces(deep));
      const auto edges = edges_of(patches);
      REQUIRE(edges);
      std::set<std::uint64_t> used;
      std::uint64_t border = 0, of_base = 0;
      for (const auto& [ends, sides] : *edges) {
        used.insert({ends.first, ends.second});
        border += sides == 1 ? 1u : 0u;
      }
      for (const EdgeId edge : deep.border_edges())
        of_base += std::uint64_t{1}
                   << std::min(level, deep.depths()->of(deep.edges()[edge].own.face()));
      CHECK(used.size() == patches.vertex_count());
      CHECK(*used.rbegin() + 1 == patches.vertex_count());
      CHECK(border == of_base);
      const LevelCounts counts = counts_at_level(deep, level);
      CHECK(counts.vertices == patches.vertex_count());
      CHECK(counts.faces == patches.triangle_count());
      CHECK(counts.edges == edges->size());
      // V - E + F
      CHECK(patches.vertex_count() + patches.triangle_count() + base.edge_count() ==
            edges->size() + base.vertex_count() + base.face_count());
    }
  }
  CHECK(patterns >= unless_sanitized(1000, 125));
}

TEST_CASE("Drawn_OfAPrunedStore_HasThePositionsOfItsVertices") {
  std::mt19937 random(8);
  for (const IndexedMesh& mesh : {random_sphere(9, 40), random_sheet(9, 40), closed_fan(6)}) {
    const TemporaryDirectory directory;
    const std::uint64_t faces = BaseMesh::build(mesh).face_count();
    const auto from =
        whole_store(directory.path() / "whole", mesh, random_depths(faces, random, kLevels));
    const auto to = directory.path() / "pruned";
    pruned(from, to, 0);
    const Store whole = open(from);
    Store store = open(to);
    const PatchSelection patches(store.base(), store.finest_level(), all_faces(store.base()));
    std::vector<Position> positions;
    const AttributeId position = store.attribute("position");
    stream_vertices(store, std::span(&position, 1), patches, [&](auto records, std::size_t count) {
      const std::size_t before = positions.size();
      positions.resize(before + count);
      std::memcpy(positions.data() + before, records[0].data(), count * sizeof(Position));
    });
    REQUIRE(positions.size() == patches.vertex_count());
    bool same = true;
    for (FaceId face = 0; face < faces; ++face) {
      const std::vector<Position> fine = patch_of(whole, face, kLevels);
      const DrawnDepths drawn = patches.drawn(face);
      const auto look = [&](FacePoint at) {
        const int finer = kLevels - drawn.grid();
        const Position& found = positions[patches.number({face, drawn.grid(), at.i, at.j})];
        const Position& right = fine[static_cast<std::size_t>(
            patch_vertex(std::int64_t{1} << kLevels, at.i << finer, at.j << finer))];
        same &= std::memcmp(&found, &right, sizeof(Position)) == 0;
      };
      for_each_drawn_triangle(
          drawn,
          [&](FacePoint a, FacePoint b, FacePoint c) {
            for (const FacePoint& at : {a, b, c}) look(at);
          },
          [] {});
    }
    CHECK(same);
  }
}

TEST_CASE("Drawn_InParts_HasTheTrianglesOfTheWhole") {
  std::mt19937 random(11);
  using Corners = std::array<std::array<float, 3>, 3>;
  for (const IndexedMesh& mesh : {random_sphere(12, 40), random_sheet(12, 40), closed_fan(7)}) {
    const TemporaryDirectory directory;
    const std::uint64_t faces = BaseMesh::build(mesh).face_count();
    const auto to = directory.path() / "pruned";
    pruned(whole_store(directory.path() / "whole", mesh, random_depths(faces, random, kLevels)), to,
           0);
    Store store = open(to);
    const auto triangles_of = [&](const PatchSelection& patches) {
      std::vector<std::array<float, 3>> positions;
      const AttributeId position = store.attribute("position");
      stream_vertices(
          store, std::span(&position, 1), patches, [&](auto records, std::size_t count) {
            const std::size_t before = positions.size();
            positions.resize(before + count);
            std::memcpy(positions.data() + before, records[0].data(), count * sizeof positions[0]);
          });
      REQUIRE(positions.size() == patches.vertex_count());
      std::vector<Corners> triangles;
      for_each_numbered_triangle(
          patches,
          [&](FaceId, std::uint64_t a, std::uint64_t b, std::uint64_t c) {
            triangles.push_back({positions.at(a), positions.at(b), positions.at(c)});
          },
          [](std::uint64_t) {});
      REQUIRE(triangles.size() == patches.triangle_count());
      return triangles;
    };
    for (const int level : {store.finest_level(), 1}) {
      const PatchSelection whole(store.base(), level, all_faces(store.base()));
      for (const std::uint64_t parts : {std::uint64_t{2}, std::uint64_t{5}, faces}) {
        std::vector<Corners> together;
        for (std::uint64_t part = 0; part < parts; ++part)
          for (const Corners& triangle :
               triangles_of(whole.part(face_stretch(whole.faces(), part, parts))))
            together.push_back(triangle);
        CHECK((together == triangles_of(whole)));
      }
    }
  }
}

TEST_CASE("Prune_ByDistance_HoldsTheToleranceOfWhatIsDrawn") {
  for (const int balance : {0, 1}) {
    CAPTURE(balance);
    const TemporaryDirectory directory;
    // Flat but for a few triangles: a sheet whose last vertices stick out.
    IndexedMesh mesh = sheet(6, 6);
    for (Vector3<double>& at : mesh.positions) at.z = 0;
    mesh.positions.back().z = 1;
    const auto from = whole_store(directory.path() / "whole", mesh, {});
    const auto to = directory.path() / "pruned";
    const double tolerance = 0.02;
    const PruneResult result = pruned(from, to, balance, "0.02");
    CHECK(result.tolerance == tolerance);
    CHECK(*result.distance <= tolerance);
    CHECK(result.copy.vertices < result.from_vertices / 2);
    const Store store = open(to);
    // Loop rounds the corners of the sheet, and moves nothing else of what is flat.
    std::uint64_t flat = 0;
    for (FaceId face = 0; face < store.base().face_count(); ++face)
      flat += store.depth(face) == 0 ? 1u : 0u;
    CHECK(2 * flat > store.base().face_count());
  }
}

namespace {

struct Soup {
  std::vector<Vector3<double>> positions;
  std::vector<std::array<VertexId, 3>> faces;
  void add(const Vector3<double>& a, const Vector3<double>& b, const Vector3<double>& c) {
    const auto first = static_cast<VertexId>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    faces.push_back({first, first + 1, first + 2});
  }
};

/// The largest distance of random points of one surface from the other one.
double sampled_distance(const Soup& from, const Soup& to, std::mt19937& random) {
  const TriangleTree tree(to.positions, to.faces);
  std::uniform_real_distribution<double> share(0, 1);
  double most = 0;
  for (const auto& face : from.faces)
    for (int turn = 0; turn < unless_sanitized(20, 5); ++turn) {
      const double r = std::sqrt(share(random)), s = share(random);
      const Vector3<double> point = (1 - r) * from.positions[face[0]] +
                                    (r * (1 - s)) * from.positions[face[1]] +
                                    (r * s) * from.positions[face[2]];
      most = std::max(most, std::sqrt(tree.closest(point).squared_distance));
    }
  return most;
}

}  // namespace

TEST_CASE("Prune_ByDistance_HoldsItForRandomPointsOfBothSurfaces") {
  std::mt19937 random(31);
  for (std::uint64_t seed = 1; seed <= unless_sanitized(3u, 1u); ++seed)
    for (const char* const wanted : {"0.5%", "2%"})
      for (const int balance : {0, 1}) {
        CAPTURE(seed, wanted, balance);
        const TemporaryDirectory directory;
        // Vertices that slide along the surface: their places on the grid say little.
        IndexedMesh mesh = random_sphere(seed, 60);
        for (Vector3<double>& at : mesh.positions) at.z *= 0.3;
        const auto from = whole_store(directory.path() / "whole", mesh, {});
        const PruneResult result = pruned(from, directory.path() / "pruned", balance, wanted);
        const Store whole = open(from), store = open(directory.path() / "pruned");
        const PatchSelection patches(store.base(), kLevels, all_faces(store.base()));
        Soup fine, drawn;
        for (FaceId face = 0; face < store.base().face_count(); ++face) {
          const std::vector<Position> records = patch_of(whole, face, kLevels);
          const auto point = [&](FacePoint at) {
            const Position& found = records[static_cast<std::size_t>(
                patch_vertex(std::int64_t{1} << kLevels, at.i, at.j))];
            return Vector3<double>{double{found.x}, double{found.y}, double{found.z}};
          };
          for_each_triangle(kLevels, [&](const std::array<FacePoint, 3>& corners) {
            fine.add(point(corners[0]), point(corners[1]), point(corners[2]));
          });
          const DrawnDepths depths = patches.drawn(face);
          const int finer = kLevels - depths.grid();
          const auto scaled = [&](FacePoint at) { return point({at.i << finer, at.j << finer}); };
          for_each_drawn_triangle(
              depths,
              [&](FacePoint a, FacePoint b, FacePoint c) {
                drawn.add(scaled(a), scaled(b), scaled(c));
              },
              [] {});
        }
        CHECK(drawn.faces.size() < fine.faces.size());
        const double most = sampled_distance(fine, drawn, random);
        CHECK(most > 0);
        CHECK(most <= *result.distance);
        CHECK(*result.distance <= *result.tolerance);
        CHECK(sampled_distance(drawn, fine, random) <= *result.tolerance);
      }
}

TEST_CASE("Prune_ByDistanceZero_KeepsAllButWhatIsFlat") {
  const TemporaryDirectory directory;
  const auto round = whole_store(directory.path() / "round", octahedron(), {});
  CHECK(pruned(round, directory.path() / "all", 1, "0").copy.vertices ==
        counts_at_level(open(round).base(), kLevels).vertices);
  const auto flat = whole_store(directory.path() / "flat", octahedron(), {}, "midpoint");
  CHECK(pruned(flat, directory.path() / "none", 1, "1e-6%").copy.vertices == 6);
}

TEST_CASE("Prune_ToANumberOfVertices_LeavesAtMostSoMany") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", random_sphere(6, 60), {});
  const std::uint64_t all = counts_at_level(open(from).base(), kLevels).vertices;
  double before = std::numeric_limits<double>::infinity();
  for (const std::uint64_t most : {all / 8, all / 3, all}) {
    const PruneRequest request{
        .vertices = most, .copy = {.from = from, .to = directory.path() / std::to_string(most)}};
    const PruneResult result = prune(request, default_backends(), default_backends());
    CHECK(result.copy.vertices <= most);
    CHECK(result.copy.vertices > most / 3);
    CHECK(*result.distance <= before);
    before = *result.distance;
  }
  CHECK(before == 0);
  const PruneRequest request{.vertices = 2,
                             .copy = {.from = from, .to = directory.path() / "none"}};
  CHECK(error_of([&] { prune(request, default_backends(), default_backends()); }).code() ==
        ErrorCode::kInvalidArgument);
}

TEST_CASE("PrunedStore_InABoxAroundAVertex_HasAllFacesOfTheVertex") {
  std::mt19937 random(12);
  const TemporaryDirectory directory;
  const IndexedMesh mesh = random_sphere(12, 40);
  const std::uint64_t faces = BaseMesh::build(mesh).face_count();
  const auto from =
      whole_store(directory.path() / "whole", mesh, random_depths(faces, random, kLevels));
  pruned(from, directory.path() / "pruned", 0);
  const Store store = open(directory.path() / "pruned");
  const Reader reader(store);
  bool found = true;
  for (FaceId face = 0; face < faces; ++face)
    for (const Position& each : patch_of(store, face, store.depth(face))) {
      const Vector3<double> at{double{each.x}, double{each.y}, double{each.z}};
      const std::vector<FaceId> there = reader.faces_in_box({at, at});
      found &= std::ranges::binary_search(there, face);
    }
  CHECK(found);
}

TEST_CASE("Prune_OfWrongRequests_IsRefusedAndLeavesNothing") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {0, 1, 2, 4});
  const auto to = directory.path() / "pruned";
  CHECK(error_of([&] { pruned(from, to, 1); }).code() == ErrorCode::kInvalidArgument);
  CHECK(error_of([&] { pruned(from, to, 1, "-1"); }).code() == ErrorCode::kInvalidArgument);
  CHECK(error_of([&] { pruned(from, to, 1, "far"); }).code() == ErrorCode::kInvalidArgument);
  CHECK_FALSE(std::filesystem::exists(to));
  pruned(from, to, 1, "50%");
  CHECK(open(to).depth(0) < kLevels);
}

TEST_CASE("PrunedStore_InWorksThatNeedAllFaces_IsRefusedInWords") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {1, 2, 3, 1});
  const auto to = directory.path() / "pruned";
  pruned(from, to, 0);
  Store store = open(to, true);
  CHECK(error_of([&] { subdivide(store, {.levels = 4, .normals = true}); }).code() ==
        ErrorCode::kNotSupported);
  CHECK(error_of([&] { PatchWriter(store, {.attributes = {"position"}}); }).code() ==
        ErrorCode::kNotSupported);
  CHECK(error_of([&] {
          store.add_attribute({"deep", ComponentType::kUint8, 1}, 4);
        }).code() == ErrorCode::kInvalidArgument);
  store.roll_back();
  CHECK(open(to).attributes().size() == 2);
  // Levels that all faces have work as ever.
  store.add_attribute({"mark", ComponentType::kUint8, 1}, 1);
  store.commit();
  const Store again = open(to);
  CHECK(again.attributes().size() == 3);
  CHECK(again.depth(2) == 3);
}

TEST_CASE("PrunedStore_Smoothed_MovesVerticesInsideAFaceByTheRingsOfItsDepth") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {1, 2, 3, 1});
  const auto to = directory.path() / "pruned";
  pruned(from, to, 0);
  const auto patches_of = [&](const Store& store) {
    const Reader reader(store);
    std::vector<std::vector<Position>> patches;
    for (FaceId face = 0; face < store.base().face_count(); ++face) {
      const PatchView patch = reader.read_patch(face, Depth::kOwn);
      patches.emplace_back(patch_vertex_count(patch.size()));
      patch.attribute<Position>("position").copy_to(patches.back());
    }
    return patches;
  };
  const auto before = patches_of(open(to));
  run_job("pass", {{"store", to.string()}, {"kind", "smooth"}, {"factor", "0.5"}});
  const Store store = open(to);
  const auto after = patches_of(store);
  int inside = 0, wrong = 0;
  for (FaceId face = 0; face < before.size(); ++face) {
    const std::int64_t size = std::int64_t{1} << store.depth(face);
    const auto at = [&](const std::vector<std::vector<Position>>& patches, std::int64_t i,
                        std::int64_t j) {
      return patches[face][static_cast<std::size_t>(patch_vertex(size, i, j))];
    };
    for (std::int64_t j = 1; j < size; ++j)
      for (std::int64_t i = 1; i + j < size; ++i) {
        const Position around = at(before, i + 1, j) + at(before, i, j + 1) +
                                at(before, i - 1, j + 1) + at(before, i - 1, j) +
                                at(before, i, j - 1) + at(before, i + 1, j - 1);
        const Position expected = 0.5f * at(before, i, j) + 0.5f / 6 * around;
        const Position off = at(after, i, j) - expected;
        ++inside;
        wrong += !(std::sqrt(dot(off, off)) < 1e-5f);
      }
  }
  CHECK(inside > 20);
  CHECK(wrong == 0);
}

TEST_CASE("Prune_ByNumbersThatMayBeNoLevels_IsRefused") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", icosahedron(), {});
  for (const auto& [type, name] :
       {std::pair(ComponentType::kFloat32, "float32"), std::pair(ComponentType::kInt8, "int8")}) {
    {
      Store store = open(from, true);
      if (!store.notes().face_attributes().empty()) store.notes().remove_face_attribute("depth");
      store.notes().add_face_attribute({"depth", type, 1});
      store.commit();
    }
    const Error error = error_of([&] { pruned(from, directory.path() / "pruned", 1); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK_THAT(error.what(), Catch::Contains("expected integers that are not negative") &&
                                 Catch::Contains(std::string("found ") + name));
  }
}

namespace {

ConversionResult compressed(const std::filesystem::path& from, const std::filesystem::path& to,
                            const std::string& preset) {
  ConversionRequest request{.from = from, .to = to, .backend = "compressed"};
  request.compression.add(preset);
  request.block_bytes = 4096;
  request.verify = true;
  return convert(request, default_backends(), default_backends());
}

bool predicts(const Store& store, const std::string& attribute, const std::string& filter) {
  const Pipeline& pipeline =
      StoreAccess::level_file(store, store.attribute(attribute), store.finest_level()).pipeline;
  return !pipeline.filters.empty() && pipeline.filters.front().name == filter;
}

}  // namespace

TEST_CASE("PrunedStore_CompressedByFiltersThatPredict_HasTheSameBits") {
  std::mt19937 random(77);
  for (const NamedMesh& named : all_meshes())
    for (const auto& [preset, balance] : {std::pair{"default", 0}, {"small", 1}}) {
      const std::uint64_t faces = BaseMesh::build(named.mesh).face_count();
      if (faces > 200) continue;
      CAPTURE(named.name, preset);
      const TemporaryDirectory directory{Medium::kMemory};
      const auto from = whole_store(directory.path() / "whole", named.mesh,
                                    random_depths(faces, random, kLevels));
      const auto plain = directory.path() / "pruned", packed = directory.path() / "packed";
      pruned(from, plain, balance);
      const std::string expected = digest(open(plain)).to_string();
      CHECK(compressed(plain, packed, preset).digest == expected);
      {
        const Store store = open(packed);
        CHECK(verify(store).damaged.empty());
        CHECK(compare_pruned(store, open(from)).difference.value_or("") == "");
        if (store.finest_level() > 0) {
          CHECK(predicts(store, "position", "hierarchy"));
          CHECK(predicts(store, "normal", "normals"));
        }
      }
      // A compressed source, whose blocks are made: the copy stores them.
      compressed(from, directory.path() / "packed whole", preset);
      pruned(directory.path() / "packed whole", directory.path() / "packed pruned", balance);
      CHECK(digest(open(directory.path() / "packed pruned")).to_string() == expected);
      CHECK(open(directory.path() / "packed pruned").options().backend == "compressed");
      // And back.
      ConversionRequest back;
      back.from = packed;
      back.to = directory.path() / "back";
      back.backend = "pread";
      convert(back, default_backends(), default_backends());
      CHECK(digest(open(back.to)).to_string() == expected);
    }
}

TEST_CASE("PrunedStore_WithDamagedCompressedBlocks_NamesThem") {
  std::mt19937 random(78);
  const TemporaryDirectory directory;
  const IndexedMesh mesh = random_sphere(9, 40);
  const auto from = whole_store(directory.path() / "whole", mesh,
                                random_depths(BaseMesh::build(mesh).face_count(), random, kLevels));
  pruned(from, directory.path() / "pruned", 0);
  const auto packed = directory.path() / "packed";
  compressed(directory.path() / "pruned", packed, "small");
  std::size_t files = 0;
  for (const auto& each : std::filesystem::directory_iterator(packed)) {
    if (each.path().filename().native().find(".level") == std::string::npos) continue;
    ++files;
    const auto size = std::filesystem::file_size(each.path());
    std::fstream file(each.path(), std::ios::binary | std::ios::in | std::ios::out);
    const auto turn = [&](std::uint64_t at) {
      file.seekg(static_cast<std::streamoff>(at));
      const auto byte = static_cast<char>(file.get() ^ 0x10);
      file.seekp(static_cast<std::streamoff>(at));
      file.put(byte).flush();
    };
    for (const std::uint64_t at : {std::uint64_t{0}, std::uint64_t{random() % size}}) {
      CAPTURE(each.path().native(), at);
      turn(at);
      const VerifyReport found = verify(open(packed));
      CHECK_FALSE(found.damaged.empty());
      const Error error = error_of([&] { digest(open(packed)); });
      CHECK(error.code() == ErrorCode::kCorruption);
      CHECK(std::string(error.what()).find("block ") != std::string::npos);
      turn(at);
    }
  }
  CHECK(files == 2 * kLevels);
  CHECK(verify(open(packed)).damaged.empty());
}

TEST_CASE("PrunedStore_WithAForgedFileOfDepths_IsRefused") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {1, 2, 3, 1});
  const auto to = directory.path() / "pruned";
  pruned(from, to, 0);
  const auto file = to / "depths";
  REQUIRE(std::filesystem::file_size(file) == 4);
  const auto write = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  };
  const auto refused = [&] {
    const Error error = error_of([&] { open(to); });
    CHECK(error.code() == ErrorCode::kCorruption);
    CHECK(std::string(error.what()).find("depths") != std::string::npos);
    const StoreCheck check = check_store(to, default_backends());
    REQUIRE(check.damaged.size() == 1);
    CHECK(check.damaged[0].kind == StoreFile::kDepths);
    return std::string(error.what());
  };
  write(std::string("\1\2\3", 3));
  CHECK(refused().find("3 bytes, expected 4") != std::string::npos);
  write(std::string("\1\2\3\2", 4));
  CHECK(refused().find("checksum") != std::string::npos);
  std::filesystem::remove(file);
  CHECK(error_of([&] { open(to); }).code() == ErrorCode::kNotFound);
  write(std::string("\1\2\3\1", 4));
  CHECK(open(to).depth(2) == 3);
}

}  // namespace plait::test::prune_test
