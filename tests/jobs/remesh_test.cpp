// A scan becomes a store: its points, its attributes, its topology; for every shape, and with
// nothing left after an error.
#include "remesh/remesh.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "conversion/conversion_job.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "remesh_files.h"
#include "support/error_of.h"
#include "support/real_meshes.h"
#include "support/sanitized.h"
#include "support/shuffled_mesh.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

/// A torus that is pressed flat, so that its sides are close together.
IndexedMesh thin_plate(std::uint32_t size) {
  IndexedMesh mesh = torus_grid(size, size);
  for (Vector3<double>& p : mesh.positions) p.z *= 0.02;
  return mesh;
}

/// A sphere with a spike that is a cusp.
IndexedMesh spiked_sphere() {
  IndexedMesh mesh = random_sphere(11, 1500);
  for (Vector3<double>& p : mesh.positions) {
    const double near = p.x / std::sqrt(dot(p, p));
    p = (1 + 4 * std::pow(std::max(0.0, near), 60)) * p;
  }
  return mesh;
}

/// Two sheets, one over the other, closer together than their vertices.
IndexedMesh double_sheet() {
  IndexedMesh mesh = sheet(30, 30);
  const auto count = static_cast<VertexId>(mesh.positions.size());
  const std::size_t faces = mesh.faces.size();
  for (VertexId v = 0; v < count; ++v) {
    Vector3<double> p = mesh.positions[v];
    p.z += 0.05;
    mesh.positions.push_back(p);
  }
  for (std::size_t f = 0; f < faces; ++f) {
    const auto [a, b, c] = mesh.faces[f];
    mesh.faces.push_back({a + count, c + count, b + count});
  }
  return mesh;
}

/// Triangles a hundred times as long as wide.
IndexedMesh slivers() {
  IndexedMesh mesh = sheet(60, 12);
  for (Vector3<double>& p : mesh.positions) p.x *= 0.01;
  return mesh;
}

/// Two sheets that share one vertex.
IndexedMesh bow_tie() {
  IndexedMesh mesh = side_by_side({sheet(12, 12), sheet(12, 12)});
  for (auto& face : mesh.faces)
    for (VertexId& vertex : face)
      if (vertex == 13 * 13) vertex = 12;
  return mesh;
}

}  // namespace

TEST_CASE("Remesh_EveryShape_KeepsItsTopologyAndStaysNear") {
  struct Shape {
    const char* name;
    IndexedMesh mesh;
    std::uint64_t faces;
    double most_rms_percent;
  };
  const std::vector<Shape> shapes = {
      {"torus", torus_grid(60, 40), 120, 0.2},
      {"thin plate", thin_plate(60), 120, 0.3},
      {"cusp", spiked_sphere(), 150, 0.5},
      {"double sheet", double_sheet(), 150, 0.5},
      {"slivers", slivers(), 100, 0.5},
      {"bow tie", bow_tie(), 80, 0.5},
      {"noise", with_noise(torus_grid(80, 60), 0.01), 200, 0.4},
      {"components", side_by_side({sheet(20, 20), torus_grid(30, 20), tetrahedron()}), 120, 0.5},
      {"tunnel and borders", annulus(40), 60, 0.5},
  };
  for (const Shape& shape : shapes) {
    CAPTURE(shape.name);
    const RemeshFiles files;
    const RemeshReport report = files.run(shuffled(shape.mesh, 3), shape.faces);
    CHECK(keeps_topology(report));
    CHECK(100 * report.to_store.rms < shape.most_rms_percent * report.diagonal);
    CHECK(100 * report.to_scan.rms < shape.most_rms_percent * report.diagonal);
    const Store store = files.open();
    CHECK(store.finest_level() == 3);
    CHECK(report.vertices == counts_at_level(store.base(), 3).vertices);
    CHECK(store.has_attribute("turned"));
  }
}

TEST_CASE("Remesh_ExportedStore_ComesBackWithinAHundredthOfItsEdges") {
  // The finest level of a store is the scan. With as many base faces, level 3 has its triangles.
  const Store store = [] {
    Store made =
        Store::create({}, BaseMesh::build(torus_grid(16, 10)),
                      {.backend = "memory", .durability = Durability::kNone}, default_backends());
    add_base_positions(made);
    subdivide(made, {.levels = 3});
    return made;
  }();
  IndexedMesh scan;
  const VertexNumbering numbering(store.base().topology(), 3);
  scan.positions.resize(numbering.vertex_count());
  for_each_patch(store, [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<float>>("position");
    for_each_triangle(3, [&](const std::array<FacePoint, 3>& corners) {
      auto& triangle = scan.faces.emplace_back();
      for (std::size_t at = 0; at < 3; ++at) {
        const FacePoint& p = corners[at];
        triangle[at] = static_cast<VertexId>(numbering.number({patch.face(), 3, p.i, p.j}));
        const Vector3<float>& q = position.at(p.i, p.j);
        scan.positions[triangle[at]] = {q.x, q.y, q.z};
      }
    });
  });
  const RemeshFiles files;
  const RemeshReport report = files.run(shuffled(scan, 9), store.base().face_count());
  CHECK(report.turned == 0);
  CHECK(report.to_store.rms < 0.01 * report.mean_edge);
  CHECK(report.to_scan.rms < 0.01 * report.mean_edge);
}

TEST_CASE("Remesh_PartsOfTheScanThatAreLost_AreAWarningWithPlaceAndRemedy") {
  const RemeshFiles files;
  std::vector<std::string> warnings;
  const JobWatch watch{.warn = [&](const std::string& what) { warnings.push_back(what); }};
  IndexedMesh fins = sheet(60, 60);
  for (Vector3<double>& p : fins.positions)
    p.z = std::abs(p.x - 20) < 1.5 && std::abs(p.y - 30) < 1.5 ? 25 : 0;
  write_ply(files.scan, fins);
  const RemeshReport report = files.run(files.request(8, 1), watch);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("more than 3 mean edges away") &&
                              Catch::Contains("--faces 32") && !Catch::Contains("--levels"));
  REQUIRE(!report.to_store.far_places.empty());
  const FarPlace& place = report.to_store.far_places[0];
  CHECK(place.distance == Approx(report.to_store.max));
  CHECK(std::abs(place.at.x - 20) < 3);
  CHECK(std::abs(place.at.y - 30) < 3);
  warnings.clear();
  CHECK(files.run(files.request(400, 3), watch).to_store.far_share == 0);
  CHECK(warnings.empty());
}

TEST_CASE("Remesh_AttributesOfTheScan_AreInterpolatedAtItsPoints") {
  const RemeshFiles files;
  write_with_attributes(files.scan, flat_sheet(20, 20));
  std::vector<std::string> warnings;
  const RemeshReport report = files.run(
      files.request(40), {.warn = [&](const std::string& what) { warnings.push_back(what); }});
  CHECK(report.attributes.size() == 4);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("turned") != std::string::npos);
  const Store store = files.open();
  double height = 0, normal = 0, color = 0;
  std::size_t labels = 0, near_labels = 0;
  for_each_patch(store, [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<float>>("position");
    const auto heights = patch.attribute<double>("height");
    const auto normals = patch.attribute<Vector3<float>>("normal");
    const auto colors = patch.attribute<std::array<std::uint8_t, 3>>("color");
    const auto label = patch.attribute<std::int32_t>("label");
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
        const Vector3<float>& p = position.at(i, j);
        const double x = double{p.x}, y = double{p.y};
        height = std::max(height, std::abs(heights.at(i, j) - (2 * x - y)));
        normal = std::max(
            normal, std::sqrt(squared_length(Vector3<double>{normals.at(i, j).x, normals.at(i, j).y,
                                                             normals.at(i, j).z} -
                                             Vector3<double>{0, 0.6, 0.8})));
        color = std::max(color, std::abs(static_cast<double>(colors.at(i, j)[0]) - x));
        color = std::max(color, std::abs(static_cast<double>(colors.at(i, j)[1]) - y));
        if (colors.at(i, j)[2] != 7) color = 99;
        const bool is_far = x < 9 || x > 10;
        if (is_far && label.at(i, j) != (x < 10 ? -5 : 9)) ++labels;
        if (label.at(i, j) != -5 && label.at(i, j) != 9) ++labels;
        // Near a vertex of the scan, in both coordinates, it is this vertex that has the label.
        if (is_far || std::abs(x - std::round(x)) > 0.3 || std::abs(y - std::round(y)) > 0.3)
          continue;
        ++near_labels;
        if (label.at(i, j) != (std::round(x) < 10 ? -5 : 9)) ++labels;
      }
  });
  CHECK(height < 1e-5);
  CHECK(normal < 1e-6);
  CHECK(color < 0.5 + 1e-5);
  CHECK(near_labels > 10);
  CHECK(labels == 0);
}

TEST_CASE("Remesh_Distances_AreThoseOfTheClosestTrianglesThatBruteForceFinds") {
  const RemeshFiles files;
  const IndexedMesh mesh = torus_grid(30, 20);
  write_ply(files.scan, mesh);
  RemeshRequest request = files.request(40, 1);
  request.distances = true;
  files.run(request);
  const Store store = files.open();
  const VertexNumbering numbering(store.base().topology(), 1);
  std::vector<std::array<Vector3<double>, 3>> triangles;
  std::vector<std::array<std::uint64_t, 3>> vertices;
  std::vector<double> found(numbering.vertex_count()), least_of(found.size()),
      most_of(found.size());
  for_each_patch(store, [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<float>>("position");
    const auto distances = patch.attribute<float>("distance");
    for_each_triangle(1, [&](const std::array<FacePoint, 3>& corners) {
      auto& triangle = triangles.emplace_back();
      auto& numbers = vertices.emplace_back();
      for (std::size_t at = 0; at < 3; ++at) {
        const FacePoint& c = corners[at];
        const Vector3<float>& p = position.at(c.i, c.j);
        triangle[at] = {p.x, p.y, p.z};
        numbers[at] = numbering.number({patch.face(), 1, c.i, c.j});
        found[numbers[at]] = double{distances.at(c.i, c.j)};
      }
    });
  });
  // Where several triangles are equally close, any of them may have the distance.
  double largest = 0;
  for (const Vector3<double>& p : mesh.positions) {
    std::vector<double> all;
    all.reserve(triangles.size());
    for (const auto& [a, b, c] : triangles)
      all.push_back(std::sqrt(squared_length(closest_of_triangle(p, a, b, c) - p)));
    const double least = *std::ranges::min_element(all);
    largest = std::max(largest, least);
    std::vector<std::size_t> closest;
    for (std::size_t at = 0; at < all.size(); ++at)
      if (all[at] < least + 1e-6) closest.push_back(at);
    for (const std::size_t at : closest)
      for (const std::uint64_t vertex : vertices[at]) {
        most_of[vertex] = std::max(most_of[vertex], least);
        if (closest.size() == 1) least_of[vertex] = std::max(least_of[vertex], least);
      }
  }
  CHECK(largest > 0.01);
  CHECK(*std::ranges::max_element(found) == Approx(largest).epsilon(1e-5));
  std::size_t wrong = 0;
  for (std::size_t vertex = 0; vertex < found.size(); ++vertex)
    wrong += found[vertex] > most_of[vertex] + 1e-6 || found[vertex] < least_of[vertex] - 1e-6;
  CHECK(wrong == 0);
}

TEST_CASE("Remesh_Compressed_IsWhatConvertMakesOfAnUncompressedStore") {
  const RemeshFiles files;
  write_with_attributes(files.scan, torus_grid(30, 20));
  for (const char* preset : {"default", "small", "fast", "hierarchy,lz4"}) {
    CAPTURE(preset);
    RemeshRequest request = files.request(40, 3);
    request.digest = true;
    request.distances = true;
    const std::string expected = files.run(request).digest;
    ConversionRequest conversion{.from = files.store,
                                 .to = files.directory.path() / "converted.plait",
                                 .backend = "compressed"};
    for (const char* attribute : {"position=", "normal=", "distance="})
      conversion.compression.add(attribute + std::string(preset));
    conversion.existing = Existing::kReplace;
    convert(conversion, default_backends(), default_backends());
    const Store converted = Store::open(conversion.to, {}, default_backends());
    request.options.backend = "auto";
    request.options.pipeline_of = [chosen = conversion.compression](const AttributeSchema& schema) {
      return chosen.pipeline_of(schema);
    };
    const RemeshReport report = files.run(request);
    CHECK(report.backend == "compressed");
    CHECK(report.digest == expected);
    Store store = files.open();
    CHECK(verify(store).damaged_count == 0);
    for (AttributeId id = 0; id < store.attributes().size(); ++id)
      for (int level = 1; level <= 3; ++level)
        CHECK(StoreAccess::level_file(store, id, level).pipeline ==
              StoreAccess::level_file(converted, id, level).pipeline);
  }
  RemeshRequest request = files.request(40, 3);
  request.options.pipeline_of = [](const AttributeSchema&) { return LevelPipelines("lz4"); };
  const Error refusal = error_of([&] { files.run(request); });
  CHECK(refusal.code() == ErrorCode::kInvalidArgument);
  CHECK(std::string_view(refusal.what()).find("pread does not") != std::string_view::npos);
}

TEST_CASE("Remesh_FilledHole_HasTheMeanOfItsBorder") {
  IndexedMesh mesh = flat_sheet(12, 12);
  std::erase_if(mesh.faces, [](const auto& face) {
    return std::ranges::find(face, VertexId{6 * 13 + 6}) != face.end();
  });
  const RemeshFiles files;
  write_with_attributes(files.scan, mesh);
  RemeshRequest request = files.request(30);
  request.repair.fill_holes = 10;
  const RemeshReport report = files.run(request);
  CHECK(report.repairs.filled_holes == 1);
  double height = 0;
  for_each_patch(files.open(), [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<float>>("position");
    const auto heights = patch.attribute<double>("height");
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
        const Vector3<float>& p = position.at(i, j);
        height = std::max(height, std::abs(heights.at(i, j) - (2 * double{p.x} - double{p.y})));
      }
  });
  CHECK(height < 1e-5);
}

TEST_CASE("Remesh_AttributeWithValuesThatAreNoNumbers_SaysHowMany") {
  const RemeshFiles files;
  std::ofstream file(files.scan);
  const IndexedMesh mesh = torus_grid(12, 10);
  file << "ply\nformat ascii 1.0\nelement vertex 120\nproperty float x\nproperty float y\nproperty "
          "float z\nproperty float age\nproperty double flow_0\nproperty double flow_1\nproperty "
          "int "
          "label\nelement face 240\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t v = 0; v < 120; ++v)
    file << mesh.positions[v].x << ' ' << mesh.positions[v].y << ' ' << mesh.positions[v].z
         << (v % 40 == 0 ? " nan" : " 1") << (v == 7 ? " nan inf 3\n" : " 1 2 3\n");
  for (const auto& f : mesh.faces) file << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
  file.close();
  std::vector<std::string> warnings;
  files.run(files.request(40),
            {.warn = [&](const std::string& what) { warnings.push_back(what); }});
  REQUIRE(warnings.size() == 2);
  CHECK_THAT(warnings[1], Catch::Contains("3 vertices of the scan have a value of 'age' that is"));
  CHECK_THAT(warnings[0], Catch::Contains("1 vertex of the scan has a value of 'flow' that is"));
}

TEST_CASE("Remesh_CoordinatesThatAreNoNumbers_AreCountedInEveryFormat") {
  const RemeshFiles files;
  const IndexedMesh mesh = torus_grid(30, 20);
  // One vertex for each axis, and each is no number in another way.
  const auto coordinates = [&](std::size_t vertex) {
    const Vector3<double>& p = mesh.positions[vertex];
    return std::array<std::string, 3>{vertex == 400 ? "-inf" : std::to_string(p.x),
                                      vertex == 205 ? "inf" : std::to_string(p.y),
                                      vertex == 77 ? "nan" : std::to_string(p.z)};
  };
  for (const char* name : {"a.ply", "a.obj", "a.off", "a.stl", "binary.stl"}) {
    CAPTURE(name);
    std::ostringstream text;
    const std::string format = name;
    if (format == "binary.stl") {
      const auto put = [&](const auto& value) {
        text.write(reinterpret_cast<const char*>(&value), sizeof value);
      };
      put(std::array<char, 80>{});
      put(std::uint32_t{1200});
      for (const auto& face : mesh.faces) {
        put(std::array<float, 3>{0, 0, 1});
        for (const VertexId vertex : face) {
          const auto [x, y, z] = coordinates(vertex);
          put(std::array<float, 3>{std::stof(x), std::stof(y), std::stof(z)});
        }
        put(std::uint16_t{0});
      }
    }
    if (format == "a.ply")
      text << "ply\nformat ascii 1.0\nelement vertex 600\nproperty float x\nproperty float y\n"
              "property float z\nelement face 1200\nproperty list uchar int vertex_indices\n"
              "end_header\n";
    if (format == "a.off") text << "OFF\n600 1200 0\n";
    if (format == "a.stl") {
      text << "solid a\n";
      for (const auto& face : mesh.faces) {
        text << "facet normal 0 0 1\nouter loop\n";
        for (const VertexId vertex : face) {
          const auto [x, y, z] = coordinates(vertex);
          text << "vertex " << x << ' ' << y << ' ' << z << '\n';
        }
        text << "endloop\nendfacet\n";
      }
      text << "endsolid a\n";
    } else if (format != "binary.stl") {
      for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
        const auto [x, y, z] = coordinates(vertex);
        text << (format == "a.obj" ? "v " : "") << x << ' ' << y << ' ' << z << '\n';
      }
      for (const auto& f : mesh.faces)
        if (format == "a.obj")
          text << "f " << f[0] + 1 << ' ' << f[1] + 1 << ' ' << f[2] + 1 << '\n';
        else
          text << "3 " << f[0] << ' ' << f[1] << ' ' << f[2] << '\n';
    }
    RemeshRequest request = files.request(100);
    request.scan = files.directory.path() / name;
    std::ofstream(request.scan, std::ios::binary) << text.str();
    const RemeshReport report = files.run(request);
    CHECK(report.repairs.not_finite_vertices == 3);
    CHECK(report.repairs.not_finite_faces == 18);
    CHECK(report.scan.borders == 3);
    CHECK(keeps_topology(report));
  }
}

TEST_CASE("Remesh_LargestDistance_IsKeptOrRefusedWithPlaces") {
  const RemeshFiles files;
  write_ply(files.scan, torus_grid(80, 60));
  RemeshRequest request = files.request(0);
  request.max_distance = RelativeLength{.number = 0.2, .is_percent = true};
  request.digest = true;
  std::uint64_t last = 0;
  const JobWatch watch{.progress = [&](const Progress& now) {
    CHECK(now.done >= last);
    last = now.done;
    return true;
  }};
  const RemeshReport report = files.run(request, watch);
  CHECK(report.max_distance == Approx(0.002 * report.diagonal));
  CHECK(report.to_store.max <= report.max_distance);
  CHECK(report.to_scan.max <= report.max_distance);
  CHECK(report.trials > 1);
  CHECK(report.small_faces < report.scan.faces * 4);
  CHECK(files.open().base().face_count() == report.base.faces);

  // The same distance in units, from the base mesh that was found.
  request.max_distance = RelativeLength{.number = report.max_distance};
  request.faces = report.faces_asked;
  request.threads = 1;
  const RemeshReport again = files.run(request);
  CHECK(again.trials == 1);
  CHECK(again.digest == report.digest);

  // As near as float32 cannot be: the last base mesh is the scan.
  write_ply(files.scan, with_noise(torus_grid(20, 20), 1e-3));
  std::filesystem::remove_all(files.store);
  request.faces = 0;
  request.precision = ComponentType::kFloat32;
  request.max_distance = RelativeLength{.number = 1e-12};
  const std::string text = error_of([&] { files.run(request); }).what();
  CHECK_THAT(text, Catch::Contains("which has 800 faces and the scan 800, around (") &&
                       Catch::Contains("--precision float64"));
  CHECK(!fs::exists(files.store));
  request.precision = ComponentType::kFloat64;
  CHECK(files.run(request).base.faces == 800);
}

TEST_CASE("Remesh_WhatCannotBe_IsRefusedAndLeavesNothing") {
  const RemeshFiles files;
  write_ply(files.scan, torus_grid(20, 20));
  const auto refused = [&](auto change, ErrorCode code, const std::string& words) {
    RemeshRequest request = files.request(100);
    change(request);
    const Error error = error_of([&] { files.run(request); });
    CHECK(error.code() == code);
    CHECK(std::string(error.what()).find(words) != std::string::npos);
    CHECK(!fs::exists(files.store));
  };
  refused([](RemeshRequest& r) { r.faces = 0; }, ErrorCode::kInvalidArgument, "faces");
  refused([](RemeshRequest& r) { r.max_distance = RelativeLength{}; }, ErrorCode::kInvalidArgument,
          "more than 0");
  refused(
      [](RemeshRequest& r) { r.max_distance = RelativeLength{.number = 1}, r.report_samples = 0; },
      ErrorCode::kInvalidArgument, "1 sample or more");
  refused([](RemeshRequest& r) { r.levels = 13; }, ErrorCode::kInvalidArgument, "levels");
  refused([](RemeshRequest& r) { r.threads = -1; }, ErrorCode::kInvalidArgument, "threads");
  // The corners of the small faces have numbers of 32 bits.
  refused([](RemeshRequest& r) { r.levels = 12, r.faces = 90; }, ErrorCode::kInvalidArgument,
          "at most 85 faces");
  refused([](RemeshRequest& r) { r.levels = 12, r.faces = 80; }, ErrorCode::kOutOfMemory,
          "of memory");
  refused([](RemeshRequest& r) { r.scan = "missing.ply"; }, ErrorCode::kNotFound, "missing.ply");
  // A tetrahedron has no fewer faces.
  write_ply(files.scan, side_by_side({torus_grid(12, 12), tetrahedron(), tetrahedron(),
                                      tetrahedron(), sheet(4, 4)}));
  for (const char* words : {"expected a base mesh of 12 faces, found ", "take --faces ",
                            "of its 5 components", "of its 1 borders"})
    refused([](RemeshRequest& r) { r.faces = 12; }, ErrorCode::kInvalidArgument, words);
  // A Moebius strip.
  write_ply(files.scan, {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {2, 0, 0}, {2, 1, 0}},
                         {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}, {4, 1, 5}, {5, 1, 0}}});
  refused([](RemeshRequest&) {}, ErrorCode::kInvalidArgument, "oriented");
}

TEST_CASE("Remesh_RealScans_StayWithinTheirDistances") {
  // What the command reached, in percent of the diagonal, and a quarter more.
  struct Scan {
    const char* name;
    double most_rms_percent;
  };
  for (const Scan& scan : {Scan{"bunny_open", 0.020}, {"skull_model", 0.015}}) {
    // A sanitizer finds no more in a mesh that is larger.
    if (!unless_sanitized(has_real_mesh(scan.name), false)) return;
    CAPTURE(scan.name);
    const RemeshFiles files;
    RemeshRequest request = files.request(1);
    request.scan = real_mesh_path(scan.name);
    request.faces = read_indexed_mesh(request.scan).faces.size() / 100;
    request.report_samples = 100000;
    const RemeshReport report = files.run(request);
    CHECK(keeps_topology(report));
    CHECK(100 * report.to_store.rms < scan.most_rms_percent * report.diagonal);
    CHECK(100 * report.to_scan.rms < scan.most_rms_percent * report.diagonal);
    CHECK(1e6 * static_cast<double>(report.turned) < 100 * static_cast<double>(report.small_faces));
  }
}

}  // namespace plait::test
