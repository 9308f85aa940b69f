// What remesh() says of scans that more faces do not help, and what helps instead.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "plait/error.h"
#include "plait/mesh_io.h"
#include "remesh/remesh.h"
#include "remesh_files.h"
#include "support/error_of.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

std::vector<std::string> warnings_of(const RemeshFiles& files, const RemeshRequest& request) {
  std::vector<std::string> warnings;
  files.run(request, {.warn = [&](const std::string& line) { warnings.push_back(line); }});
  return warnings;
}

bool any_has(const std::vector<std::string>& lines, std::string_view part) {
  return std::ranges::any_of(
      lines, [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

/// A ground of waves, in a box of side 1.
IndexedMesh with_waves(IndexedMesh mesh, double size) {
  for (Vector3<double>& p : mesh.positions) {
    p = {p.x / size, p.y / size, 0};
    p.z = 0.15 * std::sin(6 * p.x) * std::cos(7 * p.y);
  }
  return mesh;
}

}  // namespace

TEST_CASE("Remesh_SheetsThatLieOnEachOther_AreToBeWeldedAndNotRefined") {
  const RemeshFiles files;
  const IndexedMesh sheet_of_waves = with_waves(sheet(50, 50), 50);
  IndexedMesh mesh = side_by_side({sheet_of_waves, sheet_of_waves});
  const std::size_t faces = mesh.faces.size(), count = sheet_of_waves.positions.size();
  for (std::size_t vertex = count; vertex < 2 * count; ++vertex)
    mesh.positions[vertex] = mesh.positions[vertex - count];
  for (std::size_t face = faces / 2; face < faces; ++face)
    std::swap(mesh.faces[face][0], mesh.faces[face][1]);
  write_ply(files.scan, mesh);
  RemeshRequest request = files.request(200, 2);
  const std::vector<std::string> warnings = warnings_of(files, request);
  CHECK(any_has(warnings,
                "sheets of the scan lie on each other there, which more faces do not "
                "part: --weld makes them one"));
  request.weld = 0;
  CHECK_FALSE(any_has(warnings_of(files, request), "pass through others"));

  // A closed box without height: its sides have no area.
  write_ply(files.scan, with_waves(cube_grid(40), 40));
  request = files.request(400, 2);
  request.feature_angle = 60;
  const Error error = error_of([&] { files.run(request); });
  CHECK_THAT(error.what(), Catch::Contains("expected a base mesh of 400 faces") &&
                               Catch::Contains(", or --weld, with a tolerance or without: 12800 of "
                                               "its faces have no area"));
  request.weld = 0;
  files.run(request);
}

TEST_CASE("Remesh_ScanWhoseDigitsWereLost_SaysSoInsteadOfAskingForMoreFaces") {
  const RemeshFiles files;
  IndexedMesh mesh = with_waves(sheet(80, 80), 80);
  for (Vector3<double>& p : mesh.positions) {
    p = 16 * p + Vector3<double>{500000.3, 5400000.7, 100};  // edges of 0.2 in metres of UTM
    p = {double{static_cast<float>(p.x)}, double{static_cast<float>(p.y)},
         double{static_cast<float>(p.z)}};
  }
  write_ply(files.scan, mesh);
  const std::vector<std::string> warnings = warnings_of(files, files.request(1600, 2));
  CHECK(any_has(warnings, "coordinates have steps of 0.5, "));
  CHECK(any_has(warnings, "write the scan as float64, or relative to a point near it"));
  CHECK(any_has(warnings, "small faces pass through others"));
  CHECK(any_has(warnings, "turned by its lost digits, and more faces do not help"));
  CHECK_FALSE(any_has(warnings, "--weld"));
  CHECK_FALSE(any_has(warnings, "take more faces where sheets"));
  const Error error = error_of([&] { files.run(files.request(100, 2)); });
  CHECK_THAT(error.what(),
             Catch::Contains(", or a scan that has the lost digits of its coordinates"));
}

TEST_CASE("Remesh_NeedlesThroughOneBox_SaysAmongHowManyFacesItLooked") {
  const RemeshFiles files;
  IndexedMesh mesh;
  constexpr std::uint32_t kNeedles = 1600;
  for (std::uint32_t i = 0; i < kNeedles; ++i) {
    const double at = i * 1e-6;
    mesh.positions.insert(mesh.positions.end(),
                          {{at, 0, 0}, {1 + at, 1, 1}, {1 + at, 1, 1 + 1e-3}});
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  write_ply(files.scan, mesh);
  RemeshRequest request = files.request(kNeedles, 1);
  request.report_samples = 100;
  request.precision = ComponentType::kFloat64;
  std::vector<std::string> warnings;
  const RemeshReport report =
      files.run(request, {.warn = [&](const std::string& line) { warnings.push_back(line); }});
  CHECK(report.scan_crossings.examined == kNeedles);
  CHECK(report.crossings.examined < 4 * kNeedles);
  CHECK(any_has(warnings, fmt::format("were looked for among the first 1600 of 1600 faces of the "
                                      "scan and {} of 6400 small faces alone",
                                      report.crossings.examined)));
}

}  // namespace plait::test
