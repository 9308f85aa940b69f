// What float32 does to positions, and the type that a store gets for them.
#include "mesh/narrowing.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "mesh_files.h"
#include "plait/extend/attributed_mesh.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;

namespace {

/// A sheet of (n + 1) squared vertices, `step` apart.
IndexedMesh ground(const Vector3<double>& origin, double step, VertexId n = 8) {
  IndexedMesh mesh;
  for (VertexId j = 0; j <= n; ++j)
    for (VertexId i = 0; i <= n; ++i)
      mesh.positions.push_back(origin + Vector3<double>{step * i, step * j, 0.01 * i * j});
  for (VertexId j = 0; j < n; ++j)
    for (VertexId i = 0; i < n; ++i) {
      const VertexId a = j * (n + 1) + i;
      mesh.faces.push_back({a, a + 1, a + n + 2});
      mesh.faces.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

ComponentType chosen(const IndexedMesh& mesh, std::optional<ComponentType> asked,
                     std::vector<std::string>& warnings, int levels = 0) {
  return precision_for(mesh, levels, asked, {}, "ground", warnings);
}

}  // namespace

TEST_CASE("PrecisionFor_GroundFarFromTheOrigin_IsFloat64AndSaysWhy") {
  // UTM metres; isl-org/Open3D #5753: ECEF metres; CloudCompare #232: a local grid.
  for (const Vector3<double>& origin : {Vector3<double>{432100, 5412345, 200},
                                        Vector3<double>{-2487002.88, -4684683.67, 3529638.98},
                                        Vector3<double>{400000.03, 800000.07, 12}}) {
    std::vector<std::string> warnings;
    CHECK(chosen(ground(origin, 0.1), {}, warnings) == ComponentType::kFloat64);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("ground: positions are float64, because float32 moves") &&
                                Contains("vertices by more than 0.001 of the shortest edge"));
    warnings.clear();
    CHECK(chosen(ground(origin, 0.1), ComponentType::kFloat32, warnings) ==
          ComponentType::kFloat32);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("precision float64"));
    warnings.clear();
    CHECK(chosen(ground(origin, 0.1), ComponentType::kFloat64, warnings) ==
          ComponentType::kFloat64);
    CHECK(warnings.empty());
  }
}

TEST_CASE("LostStep_NumbersOfFloat32FarFromTheOrigin_IsTheirLargestStep") {
  const auto cut = [](IndexedMesh mesh) {
    for (Vector3<double>& p : mesh.positions) p = float32_position(p);
    return mesh.positions;
  };
  const Vector3<double> utm = {500000.3, 5400000.7, 100};
  CHECK(lost_step(cut(ground(utm, 0.2, 40)), 0.2) == 0.5);
  CHECK(lost_step(cut(ground({500000.3, 0, 0}, 0.2, 40)), 0.2) == 0.03125);
  // With all digits; with edges of many steps; whole numbers; near the origin.
  CHECK(lost_step(ground(utm, 0.2, 40).positions, 0.2) == 0);
  CHECK(lost_step(cut(ground(utm, 6, 40)), 6) == 0);
  CHECK(lost_step(cut(ground({500000, 5400000, 100}, 1, 40)), 1) == 0);
  CHECK(lost_step(cut(ground({0.3, 0.7, 0}, 0.2, 40)), 0.2) == 0);
  CHECK(lost_step({}, 0) == 0);
}

TEST_CASE("PrecisionFor_MeshThatFloat32Has_IsFloat32WithoutAWord") {
  std::vector<std::string> warnings;
  CHECK(chosen(shapes::octahedron(), {}, warnings) == ComponentType::kFloat32);
  CHECK(chosen(ground({0.1, 0.2, 0.3}, 0.1), {}, warnings) == ComponentType::kFloat32);
  CHECK(chosen(ground({1e6, 1e6, 0}, 1), {}, warnings) == ComponentType::kFloat32);
  CHECK(chosen(ground({432100, 5412345, 0}, 1000), {}, warnings) == ComponentType::kFloat32);
  CHECK(warnings.empty());
}

TEST_CASE("PrecisionFor_FinerLevelsThatFloat32CannotTellApart_IsFloat64AndSaysWhy") {
  // Whole numbers, so that float32 has the mesh itself; its step there is 0.5.
  const IndexedMesh far = ground({5000000, 400000, 0}, 10);
  IndexedMesh whole = far;
  for (Vector3<double>& p : whole.positions) p.z = 0;
  std::vector<std::string> warnings;
  CHECK(chosen(whole, {}, warnings, 0) == ComponentType::kFloat32);
  CHECK(warnings.empty());
  CHECK(chosen(whole, {}, warnings, 6) == ComponentType::kFloat64);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0],
             Contains("positions are float64, because float32 has steps of 0.5 where edges are "
                      "0.221 long at level 6 (around 81 vertices)"));
  warnings.clear();
  CHECK(chosen(whole, ComponentType::kFloat32, warnings, 6) == ComponentType::kFloat32);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("precision float64"));
}

TEST_CASE("PrecisionFor_DeepLevelsAroundTheOrigin_AreFloat32") {
  std::vector<std::string> warnings;
  CHECK(chosen(shapes::octahedron(), {}, warnings, 15) == ComponentType::kFloat32);
  CHECK(chosen(ground({0, 0, 0}, 0.125), {}, warnings, 12) == ComponentType::kFloat32);
  // One needle says nothing about precision.
  IndexedMesh needle = ground({0, 0, 0}, 0.125);
  for (Vector3<double>& p : needle.positions) p.z = 0;
  needle.positions[1].x = 0x1p-16;
  CHECK(chosen(needle, {}, warnings, 6) == ComponentType::kFloat32);
  CHECK(warnings.empty());
}

TEST_CASE("NarrowingOf_VerticesThatBecomeEqual_AreCounted") {
  IndexedMesh mesh = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1 + 1e-12, 0, 0}, {2, 1, 0}, {1, 0, 0}},
                      {{0, 1, 2}, {3, 4, 5}}};
  CHECK(narrowing_of(mesh.positions, mesh.faces).merged == 1);
  mesh.positions[4] = {1e300, 0, 0};
  CHECK(narrowing_of(mesh.positions, mesh.faces).outside == 1);
  mesh.positions[4] = {NAN, 0, 0};
  CHECK(narrowing_of(mesh.positions, mesh.faces).outside == 0);
}

TEST_CASE("ReadAttributedMesh_FloatsOfTextWithMoreDigits_AreSaidWithTheirNumber") {
  const MeshDirectory directory;
  const auto warnings_of = [&](const std::string& type, const std::string& value) {
    std::vector<std::string> warnings;
    read_attributed_mesh(
        directory.file("a.ply",
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                       "property float y\nproperty float z\nproperty " +
                           type +
                           " time\nelement face 1\nproperty list uchar int "
                           "vertex_indices\nend_header\n0 0 0 " +
                           value + "\n1 0 0 1\n0 1 0 " + value + "\n3 0 1 2\n"),
        &warnings);
    return warnings;
  };
  for (const char* const lost : {"1234567890.125", "16777217", "0.123456789", "1.6777217e7"}) {
    const std::vector<std::string> warnings = warnings_of("float", lost);
    INFO(lost);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("'time': 2 numbers have more digits than float"));
    CHECK(warnings_of("double", lost).empty());
  }
  CHECK_THAT(warnings_of("float", "16777217").at(0), Contains("the largest change is 1)"));
  // What a program writes that prints a float with enough digits, or with less.
  for (const char* const kept : {"0.1", "0.10000000149011612", "0.123456791", "1e30", "16777216",
                                 "2500000", "-3.5E-3", "nan", "0.333333343", "1234.57"}) {
    INFO(kept);
    CHECK(warnings_of("float", kept).empty());
  }
  CHECK_THROWS_WITH(warnings_of("float", "1e300"),
                    Contains("expected a number of the type of 'time', found 1e+300"));
}

TEST_CASE("ReadAttributedMesh_CoordinateTypes_AreThoseThatTheFileNeeds") {
  const MeshDirectory directory;
  const auto precision = [&](const std::string& type, const std::string& x, bool binary = false) {
    std::string bytes = "ply\nformat " + std::string(binary ? "binary_little_endian" : "ascii") +
                        " 1.0\nelement vertex 3\n";
    for (const char* name : {"x", "y", "z"}) bytes += "property " + type + " " + name + "\n";
    bytes += "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    if (binary) {
      for (int i = 0; i < 9; ++i) append_number(bytes, std::stoi(x) + i);
      append_number(bytes, std::uint8_t{3});
      for (int i = 0; i < 3; ++i) append_number(bytes, i);
    } else {
      bytes += x + " 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    }
    return read_attributed_mesh(directory.file("a.ply", bytes)).precision;
  };
  CHECK(precision("double", "1") == ComponentType::kFloat64);
  CHECK(precision("int", "431234501") == ComponentType::kFloat64);
  CHECK(precision("int", "431234501", true) == ComponentType::kFloat64);
  CHECK(precision("uint", "16777217") == ComponentType::kFloat64);
  CHECK(precision("int", "16777216") == ComponentType::kFloat32);
  CHECK(precision("int", "1000", true) == ComponentType::kFloat32);
  CHECK(precision("short", "30000") == ComponentType::kFloat32);
  // meshlab #378: text of type float with more digits than float32 has.
  CHECK(!precision("float", "412345.678").has_value());
}
