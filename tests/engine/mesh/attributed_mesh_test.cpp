// Attributes of PLY files keep their types and numbers, in every format of the file; STL files give
// vertices.
#include "plait/extend/attributed_mesh.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "engine/mesh/mesh_files.h"
#include "support/error_of.h"

using namespace plait;
using namespace plait::mesh_files;

namespace {

struct Property {
  std::string type, name;
  double value;  ///< of vertex v: value + v
};

const std::vector<Property> kProperties = {
    {"float", "nx", 0.25},       {"double", "weight", 1e300}, {"uchar", "red", 250},
    {"float", "x", 1},           {"short", "stress_1", -300}, {"uchar", "green", 3},
    {"float", "y", 2},           {"short", "stress_0", 7},    {"uchar", "blue", 4},
    {"float", "ny", -0.5},       {"float", "z", 3},           {"float", "nz", 8},
    {"int", "id", -2e9},         {"uint", "mark", 4e9},       {"char", "kind", -128},
    {"ushort", "u", 65000},      {"ushort", "v", 12},         {"float", "flow_x", 1},
    {"float", "flow_y", 2},      {"float", "flow_z", 3},      {"uchar", "alpha", 9},
    {"float", "quality", 0.125}, {"float", "bad.name", 5},    {"short", "odd_0", 5},
    {"float", "odd_1", 5}};

template <class Number>
void append(std::string& bytes, double value, const std::string& format) {
  if (format == "ascii")
    bytes += std::to_string(static_cast<long double>(static_cast<Number>(value))) + " ";
  else
    append_number(bytes, static_cast<Number>(value), format == "binary_big_endian");
}

void append_typed(std::string& bytes, const std::string& type, double value,
                  const std::string& format) {
  if (type == "float") append<float>(bytes, value, format);
  if (type == "double") append<double>(bytes, value, format);
  if (type == "char") append<std::int8_t>(bytes, value, format);
  if (type == "uchar") append<std::uint8_t>(bytes, value, format);
  if (type == "short") append<std::int16_t>(bytes, value, format);
  if (type == "ushort") append<std::uint16_t>(bytes, value, format);
  if (type == "int") append<std::int32_t>(bytes, value, format);
  if (type == "uint") append<std::uint32_t>(bytes, value, format);
}

std::string ply_file(const std::string& format, bool with_list) {
  std::string header = "ply\nformat " + format + " 1.0\nelement vertex 3\n";
  std::string body;
  for (const Property& property : kProperties)
    header += "property " + property.type + " " + property.name + "\n";
  if (with_list) header += "property list uchar int neighbours\n";
  for (int vertex = 0; vertex < 3; ++vertex) {
    for (const Property& property : kProperties)
      append_typed(body, property.type, property.value + vertex, format);
    if (with_list) {
      append_typed(body, "uchar", 2, format);
      append_typed(body, "int", 1, format);
      append_typed(body, "int", 2, format);
    }
    if (format == "ascii") body += "\n";
  }
  append_typed(body, "uchar", 3, format);
  for (int corner = 0; corner < 3; ++corner) append_typed(body, "int", corner, format);
  return header + "element face 1\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

template <class Record>
std::vector<Record> records_of(const AttributedMesh& mesh, const std::string& name) {
  for (const MeshAttribute& attribute : mesh.attributes)
    if (attribute.schema == schema_of<Record>(name)) {
      std::vector<Record> records(attribute.records.size() / sizeof(Record));
      std::memcpy(records.data(), attribute.records.data(), attribute.records.size());
      return records;
    }
  FAIL("no attribute " << name << " of this type");
  return {};
}

}  // namespace

TEST_CASE("ReadAttributedMesh_EveryPlyFormat_KeepsTypesAndNumbers") {
  const auto format =
      GENERATE(as<std::string>(), "ascii", "binary_little_endian", "binary_big_endian");
  const auto with_list = GENERATE(false, true);
  const MeshDirectory directory;
  std::vector<std::string> warnings;
  const AttributedMesh read =
      read_attributed_mesh(directory.file("a.ply", ply_file(format, with_list)), &warnings);
  CHECK(read.mesh.positions.at(1) == Vector3<double>{2, 3, 4});
  CHECK(read.mesh.faces.size() == 1);
  if (format == "ascii")
    CHECK(!read.precision);  // text may have more digits than float32
  else
    CHECK(read.precision == ComponentType::kFloat32);
  CHECK(records_of<Vector3<float>>(read, "normal").at(2) == Vector3<float>{2.25f, 1.5f, 10});
  CHECK(records_of<double>(read, "weight").at(0) == 1e300);
  CHECK(records_of<std::array<std::uint8_t, 4>>(read, "color").at(1) ==
        std::array<std::uint8_t, 4>{251, 4, 5, 10});
  CHECK(records_of<std::array<std::int16_t, 2>>(read, "stress").at(2) ==
        std::array<std::int16_t, 2>{9, -298});
  CHECK(records_of<std::array<std::uint16_t, 2>>(read, "texture").at(2) ==
        std::array<std::uint16_t, 2>{65002, 14});
  CHECK(records_of<Vector3<float>>(read, "flow").at(0) == Vector3<float>{1, 2, 3});
  CHECK(records_of<std::int32_t>(read, "id").at(0) == -2000000000);
  CHECK(records_of<std::uint32_t>(read, "mark").at(2) == 4000000002u);
  CHECK(records_of<std::int8_t>(read, "kind").at(1) == -127);
  CHECK(records_of<float>(read, "quality").at(1) == 1.125f);
  CHECK(records_of<std::int16_t>(read, "odd_0").at(0) == 5);
  CHECK(records_of<float>(read, "odd_1").at(0) == 5);
  CHECK(read.attributes.size() == 12);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("bad.name") != std::string::npos);
  CHECK((warnings[0].find("neighbours") != std::string::npos) == with_list);
}

TEST_CASE("ReadAttributedMesh_PropertiesOfFaces_AreKeptForEachTriangleOnRequest") {
  const auto format =
      GENERATE(as<std::string>(), "ascii", "binary_little_endian", "binary_big_endian");
  const auto with_list = GENERATE(false, true);
  const MeshDirectory directory;
  std::string body;
  for (int vertex = 0; vertex < 4; ++vertex) {
    for (const int number : {vertex % 2, vertex / 2, 0})
      append_typed(body, "float", number, format);
    if (format == "ascii") body += "\n";
  }
  // The second face is a square.
  for (const int corners : {3, 4}) {
    append_typed(body, "short", -corners, format);
    append_typed(body, "uchar", corners, format);
    for (const int corner : {0, 1, 3, 2})
      if (corner != 2 || corners == 4) append_typed(body, "int", corner, format);
    append_typed(body, "double", 0.5 + corners, format);
    append_typed(body, "uint", 4e9 + corners, format);
    if (with_list) append_typed(body, "uchar", 0, format);
    if (format == "ascii") body += "\n";
  }
  std::string text = "ply\nformat " + format +
                     " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
                     "z\nelement face 2\nproperty short first\nproperty list uchar int "
                     "vertex_indices\nproperty double second\nproperty uint third\n";
  if (with_list) text += "property list uchar int empty\n";
  const auto path = directory.file("a.ply", text + "end_header\n" + body);
  std::vector<std::string> warnings;
  AttributedMesh read = read_attributed_mesh(path, &warnings, NotFinite::kRefuse, OfFaces::kKeep);
  REQUIRE(read.mesh.faces.size() == 3);
  CHECK(read.face_attributes.size() == 3);
  read.attributes = std::move(read.face_attributes);
  CHECK(records_of<std::int16_t>(read, "first") == std::vector<std::int16_t>{-3, -4, -4});
  CHECK(records_of<double>(read, "second") == std::vector<double>{3.5, 4.5, 4.5});
  CHECK(records_of<std::uint32_t>(read, "third") ==
        std::vector<std::uint32_t>{4000000003u, 4000000004u, 4000000004u});
  REQUIRE(warnings.size() == (with_list ? 2 : 1));
  if (with_list) CHECK_THAT(warnings[1], Catch::Contains("left out: properties empty of 2 faces"));
  warnings.clear();
  CHECK(read_attributed_mesh(path, &warnings).face_attributes.empty());
  REQUIRE(warnings.size() == 2);
  CHECK_THAT(warnings[1], Catch::Contains("left out: properties first, second, third"));
}

TEST_CASE("ReadAttributedMesh_NumberBeyondItsType_IsRefused") {
  const MeshDirectory directory;
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty "
      "double z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\n"
      "end_header\n0 0 0 1\n1 0 0 300\n0 1 0 3\n3 0 1 2\n";
  const Error error = test::error_of([&] { read_attributed_mesh(directory.file("a.ply", text)); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK(std::string(error.what()).find("300") != std::string::npos);
}

TEST_CASE("ReadStl_TextAndBinary_WeldEqualCorners") {
  const MeshDirectory directory;
  const std::array<std::array<float, 9>, 2> facets = {
      {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, -0.0f, 1, 1, 0.5f, 0, 1, 0}}};
  std::string text = "solid a square\n", binary(80, ' ');
  append_number(binary, std::uint32_t{2});
  for (const auto& facet : facets) {
    text += " facet normal 0 0 1\n  outer loop\n";
    for (int i = 0; i < 3; ++i) append_number(binary, 0.0f);
    for (std::size_t at = 0; at < 9; ++at) {
      append_number(binary, facet[at]);
      if (at % 3 == 0) text += "   vertex";
      text += " " + std::to_string(facet[at]) + (at % 3 == 2 ? "\n" : "");
    }
    append_number(binary, std::uint16_t{0});
    text += "  endloop\n endfacet\n";
  }
  text += "endsolid a square\n";
  for (const std::string& file : {text, binary, gzip(binary)}) {
    const IndexedMesh mesh = read_indexed_mesh(
        directory.file(file == text || file == binary ? "a.stl" : "a.stl.gz", file));
    CHECK(mesh.positions.size() == 4);
    CHECK(mesh.faces == std::vector<std::array<VertexId, 3>>{{0, 1, 2}, {1, 3, 2}});
    CHECK(mesh.positions[3] == Vector3<double>{1, 1, 0.5});
  }
  const auto refused = [&](const std::string& bytes, const std::string& words) {
    const Error error = test::error_of([&] { read_indexed_mesh(directory.file("b.stl", bytes)); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(std::string(error.what()).find(words) != std::string::npos);
  };
  refused(binary.substr(0, 150), "facet 1: expected all 2 of them");
  refused(binary + "x", "expected the end after 2 facets");
  refused(binary.substr(0, 40), "expected solid, found the end of the file");
  refused(std::string(40, '\1'), "header of 84 bytes");
  std::string not_finite = binary;
  not_finite.replace(84 + 12, 4, "\xff\xff\xff\x7f");
  refused(not_finite, "facet 0: expected a finite number");
  refused("solid x\nfacet normal 0 0 1\nouter loop\nvertex 1 2 3\nendloop\nendfacet\n",
          "three vertices");
  refused("solid x\nfacet normal 0 0 1\nvertex 1 2 nan\n", "a finite number");
  refused("solid x\nfacet normal 0 0 1\nvertex 1 2 3\n", "three vertices, found the end");
  refused("solid x\nfacets\n", "facet or endsolid");
}

TEST_CASE("ReadAttributedMesh_ObjWithColoursOfAllVertices_KeepsThem") {
  const MeshDirectory directory;
  const std::string vertices = "v 0 0 0 0.25 0.5 1\nv 1 0 0 0 0.125 1\nv 0 1 0 1 1 1";
  const std::string face = "\nf 1 2 3\n";
  std::vector<std::string> warnings;
  const AttributedMesh all =
      read_attributed_mesh(directory.file("a.obj", vertices + face), &warnings);
  CHECK(warnings.empty());
  REQUIRE(all.attributes.size() == 1);
  CHECK(all.attributes[0].schema.name == "color");
  CHECK(all.attributes[0].schema.type == ComponentType::kFloat32);
  CHECK(all.attributes[0].schema.components == 3);
  const std::vector<float> expected = {0.25, 0.5, 1, 0, 0.125, 1, 1, 1, 1};
  REQUIRE(all.attributes[0].records.size() == 9 * sizeof(float));
  CHECK(std::memcmp(all.attributes[0].records.data(), expected.data(), 9 * sizeof(float)) == 0);
  // A record for each vertex, or none.
  const AttributedMesh some =
      read_attributed_mesh(directory.file("b.obj", vertices + "\nv 0 0 1" + face), &warnings);
  CHECK(some.attributes.empty());
  REQUIRE(!warnings.empty());
  CHECK(warnings[0].find("left out: colours of 3 vertices") != std::string::npos);
}

TEST_CASE("ReadAttributedMesh_ObjWithTextureAtAllCorners_KeepsThatOfTheFirst") {
  const MeshDirectory directory;
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 9 9 9\n";
  const auto read = [&](const std::string& faces) {
    std::vector<std::string> warnings;
    const AttributedMesh mesh =
        read_attributed_mesh(directory.file("a.obj", vertices + faces), &warnings);
    std::vector<float> numbers;
    if (!mesh.attributes.empty()) {
      CHECK(mesh.attributes[0].schema.name == "texture");
      CHECK(mesh.attributes[0].schema.type == ComponentType::kFloat32);
      CHECK(mesh.attributes[0].schema.components == 2);
      numbers.resize(mesh.attributes[0].records.size() / sizeof(float));
      std::memcpy(numbers.data(), mesh.attributes[0].records.data(),
                  mesh.attributes[0].records.size());
    }
    return std::pair(numbers, warnings.empty() ? "" : warnings[0]);
  };
  const auto has = [](const std::string& text, std::string_view part) {
    return text.find(part) != std::string::npos;
  };
  const std::vector<float> expected = {0, 0, 0.5, 0, 0, 0.25, 1, 1, 0, 0};
  const std::string numbers = "vt 0\nvt 0.5 0\nvt 0 0.25 0\nvt 1 1\nvt 0.5 0 0\n";
  // Equal numbers at another place are no seam; back from the last, and before the coordinates.
  for (const std::string& faces : {numbers + "f 1/1 2/2 3/3\nf 2/5/7 4/4 3/3\n",
                                   numbers + "f 1/-5 2/-4 3/-3\nf 2/2 4/-2 3/3\n",
                                   "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n" + numbers}) {
    CAPTURE(faces);
    const auto [found, warning] = read(faces);
    CHECK(found == expected);
    CHECK(warning.empty());
  }
  const auto [seam, of_seam] = read(numbers + "f 1/1 2/2 3/3\nf 2/4 4/4 3/3\nf 2/1 4/4 3/4\n");
  CHECK(seam == expected);
  CHECK(has(of_seam, "texture coordinates of further corners, at seams, of 2 vertices"));
  for (const std::string faces : {"f 1/1 2/2 3/3\nf 2 4/4 3/3\n", "f 1/1 2/2 3/6\n",
                                  "f 1/1 2/2 3/-6\n", "f 1//1 2//1 3//1\n"}) {
    CAPTURE(faces);
    const auto [found, warning] = read(numbers + faces);
    CHECK(found.empty());
    CHECK(has(warning, "left out: 5 texture coordinates, because some corners have none"));
  }
  const auto third = read("vt 0 0 0.5\nf 1/1 2/1 3/1\n");
  CHECK(third.first.size() == 10);
  CHECK(has(third.second, "left out: 1 third texture coordinate"));
  CHECK_THROWS_WITH(read("vt 0 zero\nf 1/1 2/1 3/1\n"),
                    Catch::Contains("texture coordinate 1: expected one to three numbers"));
}
