// Stores whose faces have depths of their own, filled to all levels, and written to files that know
// no depths.
#include "conversion/uniform_levels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "conversion/conversion_job.h"
#include "export/export_mesh.h"
#include "jobs/pruned_stores.h"
#include "plait/digest.h"
#include "plait/job.h"
#include "plait/mesh_io.h"
#include "plait/patch_writer.h"
#include "plait/verify.h"
#include "prune/compare_pruned.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test::uniform_levels_test {
namespace {

ConversionRequest uniform_copy(const std::filesystem::path& from, const std::filesystem::path& to) {
  return {.from = from, .to = to, .verify = true, .uniform = true};
}

ConversionResult convert_by(const ConversionRequest& request) {
  return convert(request, default_backends(), default_backends());
}

std::vector<IndexedMesh> some_meshes() {
  return {tetrahedron(),    seven_vertex_torus(), open_fan(5),        closed_fan(6),
          two_components(), random_sphere(3, 40), random_sheet(4, 40)};
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

TEST_CASE("Uniform_OfAPrunedMidpointStore_HasThePositionsOfAllLevelsAgain") {
  std::mt19937 random(21);
  for (const IndexedMesh& mesh : some_meshes()) {
    const TemporaryDirectory directory;
    const std::uint64_t faces = BaseMesh::build(mesh).face_count();
    const auto from = whole_store(directory.path() / "whole", mesh,
                                  random_depths(faces, random, kLevels), "midpoint");
    {
      Store store = open(from, true);
      store.remove_attribute(store.attribute("normal"));
      store.commit();
    }
    pruned(from, directory.path() / "pruned", 0);
    const ConversionResult result =
        convert_by(uniform_copy(directory.path() / "pruned", directory.path() / "uniform"));
    const Store whole = open(from), deep = open(directory.path() / "pruned");
    Store uniform = open(directory.path() / "uniform");
    CHECK_FALSE(uniform.has_depths());
    CHECK(uniform.finest_level() == deep.finest_level());
    if (deep.finest_level() == kLevels) CHECK(digest(uniform) == digest(whole));
    CHECK(result.digest == digest(uniform).to_string());
    CHECK(result.filled_vertices == counts_at_level(whole.base(), deep.finest_level()).vertices -
                                        counts_at_level(deep.base(), deep.finest_level()).vertices);
    CHECK(verify(uniform).damaged.empty());
    CHECK(uniform.provenance().scheme.empty());
    CHECK(std::as_const(uniform).notes().face_bytes("depth").size() == faces);
  }
}

TEST_CASE("Uniform_OfALoopStore_KeepsTheBitsOfWhatIsThere") {
  std::mt19937 random(22);
  int without_direction = 0, wrong = 0;
  for (const IndexedMesh& mesh : some_meshes()) {
    const TemporaryDirectory directory;
    const std::uint64_t faces = BaseMesh::build(mesh).face_count();
    const auto from =
        whole_store(directory.path() / "whole", mesh, random_depths(faces, random, kLevels));
    pruned(from, directory.path() / "pruned", 0);
    convert_by(uniform_copy(directory.path() / "pruned", directory.path() / "uniform"));
    const Store deep = open(directory.path() / "pruned");
    Store uniform = open(directory.path() / "uniform", true);
    CHECK(compare_pruned(deep, uniform).difference.value_or("") == "");
    const Reader reader(uniform);
    for (FaceId face = 0; face < faces; ++face) {
      const PatchView patch = reader.read_patch(face, uniform.finest_level());
      const auto normals = patch.attribute<Vector3<float>>("normal");
      for (std::int64_t j = 0; j <= patch.size(); ++j)
        for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
          const Vector3<float>& n = normals.at(i, j);
          const double length = std::hypot(double{n.x}, double{n.y}, double{n.z});
          // Normals of two parents that are opposite have no direction in the middle.
          without_direction += length == 0 ? 1 : 0;
          wrong += length != 0 && std::fabs(length - 1) >= 1e-6;
        }
    }
  }
  CHECK(wrong == 0);
  CHECK(without_direction < 10);
  // What needs all faces works on the copy.
  const TemporaryDirectory directory;
  pruned(whole_store(directory.path() / "whole", tetrahedron(), {0, 1, 2, 3}),
         directory.path() / "pruned", 0);
  convert_by(uniform_copy(directory.path() / "pruned", directory.path() / "uniform"));
  Store store = open(directory.path() / "uniform", true);
  subdivide(store, {.levels = 4, .normals = true});
  CHECK(store.finest_level() == 4);
}

TEST_CASE("Uniform_OfIntegers_HasTheirMeanRoundedDown") {
  const TemporaryDirectory directory;
  const auto path = whole_store(directory.path() / "whole", two_triangles(), {0, 0});
  {
    Store store = open(path, true);
    store.add_attribute({"height", ComponentType::kInt16, 2}, 1);
    PatchWriter writer(store, {.attributes = {"height"}});
    using Pair = std::array<std::int16_t, 2>;
    const std::array<Pair, 4> corners = {{{-32768, 5}, {32767, -2}, {1, 32767}, {-4, -32768}}};
    for (FaceId face = 0; face < 2; ++face) {
      const auto& f = store.base().faces()[face];
      std::vector<Pair> records(6, Pair{7, 7});
      records[0] = corners[f[0]], records[2] = corners[f[1]], records[5] = corners[f[2]];
      writer.write_patch<Pair>("height", face, 1, records);
    }
    writer.finish();
    const auto depths = store.notes().face_records<std::uint8_t>("depth");
    depths[1] = 1;
    store.commit();
  }
  pruned(path, directory.path() / "pruned", 0);
  convert_by(uniform_copy(directory.path() / "pruned", directory.path() / "uniform"));
  const Store store = open(directory.path() / "uniform");
  const Reader reader(store, {.attributes = {"height"}});
  const PatchView patch = reader.read_patch(0, 1);
  const auto height = patch.attribute<std::array<std::int16_t, 2>>("height");
  const Topology mesh = store.base().topology();
  const auto mean = [](int a, int b) {
    return static_cast<int>(std::floor((static_cast<double>(a) + b) / 2));
  };
  const std::array<std::array<std::int64_t, 2>, 3> corner = {{{0, 0}, {2, 0}, {0, 2}}},
                                                   middle = {{{1, 1}, {0, 1}, {1, 0}}};
  int kept = 0;
  for (std::size_t side = 0; side < 3; ++side)
    for (std::size_t number = 0; number < 2; ++number) {
      const auto& a = corner[(side + 1) % 3];
      const auto& b = corner[(side + 2) % 3];
      const int found = height.at(middle[side][0], middle[side][1])[number];
      const int made = mean(height.at(a[0], a[1])[number], height.at(b[0], b[1])[number]);
      // Face 1 has the vertex on the common side.
      const bool common = mesh.across(FaceSide(0, static_cast<int>(side))).exists();
      CHECK(found == (common ? 7 : made));
      kept += common ? 1 : 0;
    }
  CHECK(kept == 2);
}

TEST_CASE("Uniform_OfWhatCannotBe_IsRefusedAndLeavesNothing") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {0, 1, 2, 3});
  ConversionRequest request = uniform_copy(from, directory.path() / "uniform");
  request.max_errors.add("1e-3");
  CHECK(error_of([&] { convert_by(request); }).code() == ErrorCode::kInvalidArgument);
  CHECK_FALSE(std::filesystem::exists(request.to));
  request.max_errors = {};
  // Of a store of all levels, it is the copy that it always was.
  CHECK(convert_by(request).filled_vertices == 0);
  CHECK(digest(open(request.to)) == digest(open(from)));
}

TEST_CASE("Render_OfDepthsWithNormalsOfAnotherType_IsRefusedByName") {
  const TemporaryDirectory directory;
  const auto from = whole_store(directory.path() / "whole", tetrahedron(), {0, 1, 2, 3});
  {
    Store store = open(from, true);
    store.remove_attribute(store.attribute("normal"));
    store.add_attribute({"normal", ComponentType::kUint16, 2}, kLevels);
    store.commit();
  }
  pruned(from, directory.path() / "pruned", 0);
  const Error error = error_of([&] {
    run_job("render", {{"store", (directory.path() / "pruned").native()},
                       {"out", (directory.path() / "picture.png").native()}});
  });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK(std::string(error.what()).find("'normal'") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(directory.path() / "picture.png"));
}

TEST_CASE("Export_OfDepths_ToFilesOfEachKind_HasTheSameTriangles") {
  std::mt19937 random(23);
  for (const IndexedMesh& mesh : some_meshes()) {
    const TemporaryDirectory directory;
    const std::uint64_t faces = BaseMesh::build(mesh).face_count();
    const auto from =
        whole_store(directory.path() / "whole", mesh, random_depths(faces, random, kLevels));
    pruned(from, directory.path() / "pruned", 0);
    const auto exported = [&](const char* name) {
      ExportRequest request;
      request.store = directory.path() / "pruned";
      request.output = directory.path() / name;
      export_mesh(request, default_backends());
      return request.output;
    };
    const IndexedMesh ply = read_indexed_mesh(exported("mesh.ply"));

    const std::string stl = bytes_of(exported("mesh.stl"));
    REQUIRE(stl.size() == 84 + 50 * ply.faces.size());
    const std::string gltf = bytes_of(exported("mesh.gltf")),
                      bin = bytes_of(directory.path() / "mesh.bin");
    const auto json = nlohmann::json::parse(gltf);
    REQUIRE(json["meshes"][0]["primitives"].size() == 1);
    REQUIRE(json["accessors"][0]["count"] == 3 * ply.faces.size());
    REQUIRE(json["accessors"][1]["count"] == ply.positions.size());
    REQUIRE(json["accessors"][0]["componentType"] == 5123);
    const std::size_t positions = json["bufferViews"][1]["byteOffset"];
    bool same = true;
    for (std::size_t face = 0; face < ply.faces.size(); ++face)
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const VertexId vertex = ply.faces[face][corner];
        const Vector3<double>& at = ply.positions[vertex];
        const Vector3<float> right{static_cast<float>(at.x), static_cast<float>(at.y),
                                   static_cast<float>(at.z)};
        same &= std::memcmp(stl.data() + 84 + 50 * face + 12 * (corner + 1), &right, 12) == 0;
        std::uint16_t index;
        std::memcpy(&index, bin.data() + 2 * (3 * face + corner), 2);
        same &= index == vertex;
        same &= std::memcmp(bin.data() + positions + 12 * index, &right, 12) == 0;
      }
    CHECK(same);
  }
}

}  // namespace plait::test::uniform_levels_test
