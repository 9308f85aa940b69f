// Normals at sharp edges: a vertex has one for each side in files that can have it.
#include "export/crease_normals.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "export/export_mesh.h"
#include "jobs/remesh_files.h"
#include "plait/notes.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

using Normal = Vector3<double>;

/// With normals that point away from `centre`, so that none is that of a side.
void write_with_normals(const std::filesystem::path& path, const IndexedMesh& mesh,
                        const Vector3<double>& centre) {
  std::ofstream file(path);
  file << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nproperty float nx\nproperty "
          "float ny\nproperty float nz\nelement face "
       << mesh.faces.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  file.precision(17);
  for (const Vector3<double>& p : mesh.positions) {
    const Normal n = normalized(p - centre);
    file << p.x << ' ' << p.y << ' ' << p.z << ' ' << static_cast<float>(n.x) << ' '
         << static_cast<float>(n.y) << ' ' << static_cast<float>(n.z) << '\n';
  }
  for (const auto& f : mesh.faces) file << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
}

/// A closed cylinder of radius 1 and height 2: `around` points on each of `rows` + 1 circles.
IndexedMesh cylinder(std::uint32_t around, std::uint32_t rows) {
  IndexedMesh mesh;
  for (std::uint32_t row = 0; row <= rows; ++row)
    for (std::uint32_t at = 0; at < around; ++at) {
      const double angle = 2 * 3.14159265358979323846 * at / around;
      mesh.positions.push_back({std::cos(angle), std::sin(angle), 2.0 * row / rows});
    }
  const VertexId low = around * (rows + 1), high = low + 1;
  mesh.positions.push_back({0, 0, 0});
  mesh.positions.push_back({0, 0, 2});
  for (std::uint32_t at = 0; at < around; ++at) {
    const std::uint32_t next = (at + 1) % around;
    for (std::uint32_t row = 0; row < rows; ++row) {
      const VertexId first = row * around;
      mesh.faces.push_back({first + at, first + next, first + around + at});
      mesh.faces.push_back({first + next, first + around + next, first + around + at});
    }
    mesh.faces.push_back({next, at, low});
    mesh.faces.push_back({rows * around + at, rows * around + next, high});
  }
  return mesh;
}

struct Corner {
  Vector3<double> at;
  Normal normal;
};
using Triangle = std::array<Corner, 3>;

Normal side_of(const Triangle& triangle) {
  return normalized(cross(triangle[1].at - triangle[0].at, triangle[2].at - triangle[0].at));
}

std::vector<Triangle> triangles_of_obj(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::vector<Vector3<double>> positions, normals;
  std::vector<Triangle> triangles;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v" || kind == "vn") {
      Vector3<double> p;
      words >> p.x >> p.y >> p.z;
      (kind == "v" ? positions : normals).push_back(p);
    } else if (kind == "f") {
      Triangle& triangle = triangles.emplace_back();
      for (Corner& corner : triangle) {
        std::size_t vertex = 0, normal = 0;
        char slash = 0;
        words >> vertex >> slash >> slash >> normal;
        corner = {positions.at(vertex - 1), normals.at(normal - 1)};
      }
    }
  }
  return triangles;
}

std::vector<Triangle> triangles_of_gltf(const std::filesystem::path& path) {
  std::ifstream text(path);
  const nlohmann::json json = nlohmann::json::parse(text);
  std::ifstream file(std::filesystem::path(path).replace_extension(".bin"), std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<Triangle> triangles;
  for (const auto& primitive : json["meshes"][0]["primitives"]) {
    const auto place_of = [&](std::size_t accessor) {
      const auto& found = json["accessors"][accessor];
      const auto& view = json["bufferViews"][found["bufferView"].get<std::size_t>()];
      return view.value("byteOffset", std::size_t{0}) + found.value("byteOffset", std::size_t{0});
    };
    const auto vector_at = [&](const char* name, std::size_t vertex) {
      Vector3<float> found;
      const auto accessor = primitive["attributes"][name].get<std::size_t>();
      std::memcpy(&found, bytes.data() + place_of(accessor) + vertex * sizeof found, sizeof found);
      return Vector3<double>{found.x, found.y, found.z};
    };
    const auto indices = primitive["indices"].get<std::size_t>();
    const auto count = json["accessors"][indices]["count"].get<std::size_t>();
    for (std::size_t at = 0; at < count; at += 3) {
      Triangle& triangle = triangles.emplace_back();
      for (std::size_t corner = 0; corner < 3; ++corner) {
        std::uint16_t vertex = 0;
        std::memcpy(&vertex, bytes.data() + place_of(indices) + 2 * (at + corner), 2);
        triangle[corner] = {vector_at("POSITION", vertex), vector_at("NORMAL", vertex)};
      }
    }
  }
  return triangles;
}

struct Exported {
  ExportResult result;
  std::vector<Triangle> triangles;
  std::vector<std::string> warnings;
};

Exported exported(const RemeshFiles& files, const std::string& name,
                  std::vector<FaceRange> faces = {}) {
  ExportRequest request;
  request.store = files.store;
  request.output = files.directory.path() / name;
  request.attributes = {"normal"};
  request.faces = std::move(faces);
  request.existing = Existing::kReplace;
  Exported done;
  done.result =
      export_mesh(request, default_backends(),
                  {.warn = [&](const std::string& warning) { done.warnings.push_back(warning); }});
  if (name.ends_with(".obj")) done.triangles = triangles_of_obj(request.output);
  if (name.ends_with(".gltf")) done.triangles = triangles_of_gltf(request.output);
  return done;
}

/// How many of the coordinates are at the sides of a cube.
int sides_of_cube(const Vector3<double>& p, double size) {
  int count = 0;
  for (const double x : {p.x, p.y, p.z}) count += x == 0 || x == size ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("Export_NormalsOfACube_AreThoseOfTheSideAtItsEdges") {
  const RemeshFiles files;
  write_with_normals(files.scan, cube_grid(4), {2, 2, 2});
  const RemeshReport report = files.run(files.request(12, 2));
  REQUIRE(report.base.faces == 12);
  const Store store = files.open();
  // Each face of the base mesh is half a side: its diagonal is no crease.
  for (const std::uint8_t bits : store.notes().face_records<std::uint8_t>("crease-sides"))
    CHECK((bits == 3 || bits == 5 || bits == 6));
  for (const char* name : {"cube.obj", "cube.gltf"}) {
    CAPTURE(name);
    const Exported done = exported(files, name);
    CHECK(done.warnings.empty());
    CHECK(done.result.side_normals == 108);
    REQUIRE(done.triangles.size() == 192);
    std::size_t at_edges = 0;
    for (const Triangle& triangle : done.triangles)
      for (const Corner& corner : triangle) {
        const bool at_edge = sides_of_cube(corner.at, 4) > 1;
        at_edges += at_edge ? 1u : 0u;
        const Normal expected =
            at_edge ? side_of(triangle) : normalized(corner.at - Vector3<double>{2, 2, 2});
        REQUIRE(std::sqrt(squared_length(corner.normal - expected)) < (at_edge ? 1e-7 : 0.2));
      }
    CHECK(at_edges > 108);
  }
  // Some of the patches have what the whole surface gives them.
  const Exported part = exported(files, "part.obj", {{0, 0}, {5, 7}});
  CHECK(part.result.side_normals == 36);
  for (const Triangle& triangle : part.triangles)
    for (const Corner& corner : triangle)
      if (sides_of_cube(corner.at, 4) > 1)
        REQUIRE(std::sqrt(squared_length(corner.normal - side_of(triangle))) < 1e-7);
}

TEST_CASE("Export_NormalsOfACylinder_AreRoundOnTheWallAndFlatOnTheLids") {
  const RemeshFiles files;
  write_with_normals(files.scan, cylinder(96, 24), {0.2, 0.1, 5});
  RemeshRequest request = files.request(200, 3);
  request.feature_angle = 45;
  REQUIRE(files.run(request).crease_edges == 192);
  for (const char* name : {"c.obj", "c.gltf"}) {
    CAPTURE(name);
    const Exported done = exported(files, name);
    // By brute force: the triangles at the same place on the wall, or on a lid.
    const auto is_on_lid = [](const Triangle& triangle) {
      return std::abs(side_of(triangle).z) > 0.5;
    };
    const auto place_of = [](const Corner& corner, bool on_lid) {
      return std::array{corner.at.x, corner.at.y, corner.at.z, on_lid ? 1.0 : 0.0};
    };
    std::map<std::array<double, 4>, Normal> sums;
    for (const Triangle& triangle : done.triangles)
      for (const Corner& corner : triangle) {
        Normal& sum = sums[place_of(corner, is_on_lid(triangle))];
        sum = sum + cross(triangle[1].at - triangle[0].at, triangle[2].at - triangle[0].at);
      }
    std::size_t on_wall = 0, on_lids = 0;
    for (const Triangle& triangle : done.triangles)
      for (const Corner& corner : triangle) {
        const double radius = std::hypot(corner.at.x, corner.at.y);
        if (radius < 0.99 || (corner.at.z != 0 && corner.at.z != 2)) continue;
        const bool on_lid = is_on_lid(triangle);
        ++(on_lid ? on_lids : on_wall);
        const Normal expected = normalized(sums.at(place_of(corner, on_lid)));
        REQUIRE(std::sqrt(squared_length(corner.normal - expected)) < 1e-5);
        REQUIRE((on_lid ? std::abs(expected.z) > 1 - 1e-6 : std::abs(expected.z) < 0.05));
      }
    CHECK(on_wall > 500);
    CHECK(on_lids > 500);
  }
}

TEST_CASE("Export_FilesWithOneNormalForAVertex_SaySoAtSharpEdges") {
  const RemeshFiles files;
  write_with_normals(files.scan, cube_grid(4), {2, 2, 2});
  files.run(files.request(12, 2));
  const Exported ply = exported(files, "cube.ply");
  CHECK(ply.result.side_normals == 0);
  REQUIRE(ply.warnings.size() == 1);
  CHECK_THAT(ply.warnings[0], Catch::Contains("44 vertices on sharp edges have one normal for all "
                                              "sides: .obj, .glb and .gltf files have one"));
  const Exported part = exported(files, "part.vtp", {{0, 0}});
  REQUIRE(part.warnings.size() == 1);
  CHECK_THAT(part.warnings[0], Catch::Contains(": 9 vertices on sharp edges"));
  RemeshRequest request = files.request(12, 2);
  request.max_distance = RelativeLength{1};
  files.run(request);
  const Exported deep = exported(files, "deep.obj");
  CHECK(deep.result.side_normals == 0);
  REQUIRE(deep.warnings.size() == 1);
  CHECK_THAT(deep.warnings[0], Catch::Contains("a store without depths would have one for each"));
}

TEST_CASE("Export_StoreWithoutSharpEdges_HasItsNormals") {
  const RemeshFiles files;
  write_with_attributes(files.scan, torus_grid(30, 20));
  files.run(files.request(60, 2));
  CHECK(files.open().notes().face_attributes().empty());
  const Exported done = exported(files, "torus.obj");
  CHECK(done.warnings.empty());
  CHECK(done.result.side_normals == 0);
  for (const Triangle& triangle : done.triangles)
    for (const Corner& corner : triangle)
      REQUIRE(std::sqrt(squared_length(corner.normal - Normal{0, 0.6, 0.8})) < 1e-6);
}

TEST_CASE("CreasePoints_OtherNumbersThanBitsOfSides_AreRefused") {
  const RemeshFiles files;
  write_with_normals(files.scan, cube_grid(4), {2, 2, 2});
  files.run(files.request(12, 2));
  Store store = Store::open(files.store, {.writable = true}, default_backends());
  store.notes().face_records<std::uint8_t>("crease-sides")[3] = 8;
  const Error error = error_of([&] { CreasePoints(store, 2); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK_THAT(error.what(),
             Catch::Contains("face 3: expected 0 to 7") && Catch::Contains("found 8"));
}

}  // namespace plait::test
