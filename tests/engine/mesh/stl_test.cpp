// Text STL in any spelling, and how text and binary files are told apart.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>

#include "mesh_files.h"
#include "plait/extend/attributed_mesh.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using shapes::refusal;

namespace {

struct Spelling {
  std::string begin = "solid part\n", facet = "facet normal 0 0 0\n", loop = "outer loop\n",
              end_loop = "endloop\n", end_facet = "endfacet\n", end = "endsolid part\n",
              between = "\n";
};

std::string stl_text(const IndexedMesh& mesh, const Spelling& words = {}) {
  std::string text = words.begin;
  for (const auto& face : mesh.faces) {
    text += words.facet + words.loop;
    for (const VertexId vertex : face) {
      const Vector3<double>& p = mesh.positions[vertex];
      text += fmt::format("vertex {} {} {}{}", p.x, p.y, p.z, words.between);
    }
    text += words.end_loop + words.end_facet;
  }
  return text + words.end;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string on_one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

IndexedMesh read(const std::string& bytes, std::vector<std::string>* warnings = nullptr,
                 const char* name = "a.stl") {
  const MeshDirectory directory;
  return read_indexed_mesh(directory.file(name, bytes), warnings);
}

std::string refused(const std::string& bytes) {
  return refusal([&] { read(bytes); });
}

void check_is_octahedron(const std::string& bytes) {
  std::vector<std::string> warnings;
  for (const bool compressed : {false, true}) {
    const IndexedMesh mesh =
        compressed ? read(gzip(bytes), &warnings, "a.stl.gz") : read(bytes, &warnings);
    CHECK(mesh.positions.size() == 6);
    CHECK(mesh.faces.size() == 8);
    CHECK(BaseMesh::build(mesh).border_edge_count() == 0);
  }
  CHECK(warnings.empty());
}

std::string stl_binary(const IndexedMesh& mesh, std::string header, std::uint16_t bytes = 0) {
  header.resize(80, ' ');
  append_number(header, static_cast<std::uint32_t>(mesh.faces.size()));
  for (const auto& face : mesh.faces) {
    for (int i = 0; i < 3; ++i) append_number(header, 0.0f);
    for (const VertexId vertex : face)
      for (int axis = 0; axis < 3; ++axis)
        append_number(header, static_cast<float>(mesh.positions[vertex][axis]));
    append_number(header, bytes);
  }
  return header;
}

}  // namespace

TEST_CASE("ReadStl_KeywordsInAnyCase_AreRead") {
  const std::string text = stl_text(shapes::octahedron());
  check_is_octahedron(text);
  check_is_octahedron(upper(text));
  check_is_octahedron(stl_text(shapes::octahedron(), {.end = "ENDSOLID Part\n"}));
  check_is_octahedron(stl_text(shapes::octahedron(), {.begin = "Solid Part\n",
                                                      .facet = "Facet Normal 0 0 1\n",
                                                      .loop = "Outer Loop\n",
                                                      .end_loop = "EndLoop\n"}));
}

TEST_CASE("ReadStl_SeveralStatementsOnALine_AreAllRead") {
  const IndexedMesh mesh = shapes::octahedron();
  const Spelling facet_on_a_line{.facet = "facet normal 0 0 0 ",
                                 .loop = "outer loop ",
                                 .end_loop = "endloop ",
                                 .between = " "};
  check_is_octahedron(stl_text(mesh, facet_on_a_line));
  check_is_octahedron(on_one_line(stl_text(mesh)));
  check_is_octahedron(on_one_line(stl_text(mesh, {.begin = "solid\n", .end = "endsolid\n"})));
  check_is_octahedron(stl_text(mesh, {.facet = "facet normal 0 0 0 "}));
  check_is_octahedron(stl_text(mesh, {.begin = "solid a facet of a name\n"}));
  // Every second facet on one line.
  IndexedMesh even = mesh, odd = mesh;
  even.faces.resize(4);
  odd.faces.erase(odd.faces.begin(), odd.faces.begin() + 4);
  std::string text = stl_text(even, {.end = ""});
  Spelling rest = facet_on_a_line;
  rest.begin = "";
  check_is_octahedron(text + stl_text(odd, rest));
  // A line end between any two words.
  text = stl_text(mesh, {.begin = "solid\n"});
  for (char& c : text) c = c == ' ' ? '\n' : c;
  check_is_octahedron(text.substr(0, text.rfind("part")));
}

TEST_CASE("ReadStl_ClosingWordsInTwo_AreRead") {
  check_is_octahedron(
      stl_text(shapes::octahedron(),
               {.end_loop = "end loop\n", .end_facet = "end facet\n", .end = "end solid part\n"}));
  check_is_octahedron(stl_text(shapes::octahedron(), {.end = "END SOLID\n"}));
}

TEST_CASE("ReadStl_NameOfAnyLength_IsPassed") {
  const IndexedMesh mesh = shapes::octahedron();
  check_is_octahedron(stl_text(mesh, {.begin = "solid " + std::string(1500, 'n') + "\n"}));
  check_is_octahedron(stl_text(mesh, {.begin = "solid " + std::string(300000, 'n') + "\n"}));
  check_is_octahedron(stl_text(mesh, {.begin = "  \n\n\t solid x\n"}));
  check_is_octahedron(stl_text(mesh, {.begin = "\xef\xbb\xbfsolid x\r\n"}));
  check_is_octahedron(stl_text(mesh, {.begin = "solid vertex facet normal loop\n"}));
}

// fstl-app/fstl #33: OpenSCAD and FreeCAD write no blank behind "solid" without a name.
// assimp/assimp #104: a file of several solids. sreiter/stl_reader #16: a facet without its end.
TEST_CASE("ReadStl_FilesThatOtherReadersCouldNotRead_AreReadOrRefused") {
  const IndexedMesh mesh = shapes::octahedron();
  check_is_octahedron(stl_text(mesh, {.begin = "solid\n", .end = "endsolid"}));
  IndexedMesh top = mesh, bottom = mesh;
  top.faces.resize(4);
  bottom.faces.erase(bottom.faces.begin(), bottom.faces.begin() + 4);
  std::vector<std::string> warnings;
  CHECK(
      read(stl_text(top) + stl_text(bottom, {.begin = "solid other\n"}), &warnings).faces.size() ==
      8);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("2 solids read as one mesh"));
  CHECK_THAT(refused(stl_text(mesh, {.end_facet = ""})),
             Contains("facet 0: expected endfacet, found 'facet'"));
  CHECK_THAT(refused(stl_text(mesh, {.facet = ""})), Contains("expected facet or endsolid"));
}

TEST_CASE("ReadStl_SolidThatBeginsOnTheLineOfAnEnd_IsReadAndCounted") {
  const IndexedMesh mesh = shapes::octahedron();
  IndexedMesh top = mesh, bottom = mesh;
  top.faces.resize(4);
  bottom.faces.erase(bottom.faces.begin(), bottom.faces.begin() + 4);
  const std::string first = stl_text(top, {.end = "endsolid part "});
  for (const std::string& text :
       {first + stl_text(bottom, {.begin = "solid other\n"}),
        on_one_line(stl_text(top) + stl_text(bottom)),
        on_one_line(stl_text(top, {.begin = "solid\n", .end = "end solid\n"}) +
                    stl_text(bottom, {.begin = "solid\n", .end = "endsolid"})),
        first + stl_text(bottom, {.begin = "\n"}) + std::string(100, '\0')}) {
    std::vector<std::string> warnings;
    CHECK(read(text, &warnings).faces.size() == 8);
    REQUIRE(!warnings.empty());
    CHECK_THAT(warnings[0], Contains("2 solids read as one mesh"));
  }
}

TEST_CASE("ReadStl_TextThatEndsEarly_IsSaid") {
  std::vector<std::string> warnings;
  CHECK(read(stl_text(shapes::octahedron(), {.end = ""}), &warnings).faces.size() == 8);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("no endsolid"));
}

TEST_CASE("ReadStl_BadText_IsRefusedWithoutBinaryCounts") {
  CHECK_THAT(refused("solid x\nfacet normal 0 0 1\nvertex 1 2 3\n"), Contains("end of the file"));
  CHECK_THAT(refused("solid x facet outer loop vertex 1 2 z\n"), Contains("'z'"));
  CHECK_THAT(refused("solid x outer loop vertex 1 2 3\n"), Contains("facet before a vertex"));
  CHECK_THAT(refused("solid x\nfacet normal 0 0 0 0 0 outer loop\n"), Contains("outer loop"));
  for (const char* start : {"facet normal 0 0 1\n", "; made by hand\n", "solids\n"}) {
    const std::string message = refused(start + stl_text(shapes::octahedron(), {.begin = ""}));
    CHECK_THAT(message, Contains("line 1: facet 0: expected solid"));
    CHECK_THAT(message, !Contains("all "));
  }
  CHECK_THAT(refused("\xff\xfes\0o\0l\0i\0d\0"), Contains("UTF-16"));
}

TEST_CASE("ReadStl_BinaryByItsSize_IsReadWhateverItsHeaderSays") {
  const IndexedMesh mesh = shapes::octahedron();
  for (const char* header : {"solid from a CAD facet", "ply with a name", "OFF to STL"}) {
    INFO(header);
    check_is_octahedron(stl_binary(mesh, header));
  }
  CHECK_THAT(refused(stl_binary(mesh, "solid").substr(0, 400)), Contains("all 8 of them"));
}

TEST_CASE("ReadStl_AttributeBytes_AreCountedAndLeftOut") {
  std::vector<std::string> warnings;
  read(stl_binary(shapes::octahedron(), "x", 7), &warnings);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("left out: attribute bytes") && Contains("of 8 facets"));
}

TEST_CASE("ReadStl_ColourInTheHeader_IsNamed") {
  for (const char* header :
       {"COLOR=\x10\x20\x30\xff,MATERIAL=", "made by x MATERIAL=abcdefghijkl"}) {
    std::vector<std::string> warnings;
    CHECK(read(stl_binary(shapes::octahedron(), header), &warnings).faces.size() == 8);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Contains("left out: 1 colour or material of the whole part"));
  }
}

TEST_CASE("ReadStl_TextCoordinates_AreDoubles") {
  const MeshDirectory directory;
  const std::string text = stl_text(
      {{{432100.125, 5412345.01, 0}, {432101.125, 5412345.02, 0}, {432100.125, 5412346.03, 0}},
       {{0, 1, 2}}});
  const AttributedMesh read = read_attributed_mesh(directory.file("a.stl", text));
  REQUIRE(read.mesh.positions.size() == 3);
  CHECK(read.mesh.positions[1].y == 5412345.02);
  CHECK(!read.precision.has_value());
  CHECK(read_attributed_mesh(directory.file("b.stl", stl_binary(shapes::octahedron(), "")))
            .precision == ComponentType::kFloat32);
}
