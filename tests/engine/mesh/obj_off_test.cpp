#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "mesh_files.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using shapes::refusal;

namespace {

IndexedMesh read(const std::string& name, const std::string& bytes,
                 std::vector<std::string>* warnings = nullptr) {
  const MeshDirectory directory;
  return read_indexed_mesh(directory.file(name, bytes), warnings);
}

std::string refused(const std::string& name, const std::string& bytes) {
  return refusal([&] { read(name, bytes); });
}

const IndexedMesh kTriangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
const std::string kObjVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("ReadObj_EveryFormOfIndex_IsRead") {
  for (const char* face :
       {"f 1 2 3", "f -3 -2 -1", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 -2/-2/-2 3/3/3",
        "f 1 \\\n 2\\\r\n  3", "\tf  +1 2 3 # why", "fo 1 2 3", "f 1 2 3#"}) {
    INFO(face);
    CHECK(same_mesh(read("a.obj", kObjVertices + face), kTriangle));
  }
}

TEST_CASE("ReadObj_OtherStatements_ArePassedOver") {
  const IndexedMesh mesh = read("a.obj",
                                "# by hand\r\nmtllib a b\\c.mtl\r\no name\r\ng one two\r\ns off\r\n"
                                "vn 0 0 1\r\nvt 0 0\r\nv 0 0 0 1.0\r\nv 1 0 0 0.5 0.5 0.5\r\n"
                                "usemtl skin\r\nv 0 1 0\r\nl 1 2\r\np 1\r\n\r\nf 1 2 3\r\n");
  CHECK(same_mesh(mesh, kTriangle));
}

TEST_CASE("ReadObj_FacesBeforeVertices_AreRead") {
  CHECK(same_mesh(read("a.obj", "f 1 2 3\n" + kObjVertices), kTriangle));
}

TEST_CASE("ReadObj_HugePolygon_IsFannedWithAWarning") {
  constexpr VertexId kCorners = 100'000;
  std::string bytes, face = "f";
  for (VertexId v = 0; v < kCorners; ++v) {
    bytes += fmt::format("v {} 0 0\n", v);
    face += fmt::format(" {}", v + 1);
  }
  std::vector<std::string> warnings;
  const IndexedMesh mesh = read("a.obj", bytes + face, &warnings);
  REQUIRE(mesh.faces.size() == kCorners - 2);
  CHECK(mesh.faces.back() == std::array<VertexId, 3>{0, kCorners - 2, kCorners - 1});
  CHECK(warnings.size() == 1);
  CHECK(BaseMesh::build(mesh).border_edge_count() == kCorners);
}

TEST_CASE("ReadObj_BadStatement_IsRefusedWithItsLine") {
  const auto with = [](const std::string& line) { return refused("a.obj", kObjVertices + line); };
  CHECK_THAT(with("f 1 2 4\n"), Contains("a.obj, line 4: face 1: expected a vertex from 1 to 3, "
                                         "found 4"));
  CHECK_THAT(with("f 1 2 0\n"), Contains("line 4") && Contains("'0'"));
  CHECK_THAT(with("f 1 2 -4\n"), Contains("at most 3 vertices back, found '-4'"));
  CHECK_THAT(with("f 1 2 4294967295\n"), Contains("'4294967295'"));
  CHECK_THAT(with("f 1 2 99999999999999999999\n"), Contains("'99999999999999999999'"));
  CHECK_THAT(with("f 1 2\n"), Contains("three corners or more, found the end of the line"));
  CHECK_THAT(with("f\n"), Contains("three corners or more"));
  CHECK_THAT(with("f 1 2 x\n"), Contains("'x'"));
  CHECK_THAT(with("f 1 2 3/1/1/1\n"), Contains("'3/1/1/1'"));
  CHECK_THAT(with("f 1 2 3/a\n"), Contains("'3/a'"));
  CHECK_THAT(with("f 1 2 /3\n"), Contains("'/3'"));
  CHECK_THAT(with("# \\\nface 1 2 3\n"), Contains("line 5: statement: expected an OBJ keyword"));
  CHECK_THAT(with("v 1 2\n"), Contains("vertex 4: expected a finite number, found the end of"));
  CHECK_THAT(with("v 1 2 nan\n"), Contains("'nan'"));
  CHECK_THAT(with("v 1 -inf 2\n"), Contains("'-inf'"));
  CHECK_THAT(with("v 1 2 3 red\n"), Contains("'red'"));
  CHECK_THAT(with("v 1 2,5 3\n"), Contains("'2,5'"));
  CHECK_THAT(with(std::string("v 1 2 \x80\x01\0\n", 10)),
             Contains("found '?") && Contains("a finite"));
  CHECK_THAT(refused("a.obj", "f 1 2 3\nf 4 5 9\nf 1 2 8\nv 0 0 0\n"),
             Contains("line 2: face 2: expected a vertex from 1 to 1, found 9"));
}

TEST_CASE("ReadOff_EveryFormOfHeader_IsRead") {
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const char* header : {"OFF\n3 1 3\n", "OFF 3 1 3\n", "OFF\n3 1\n", "OFF\n3\n1\n",
                             "OFF # sides\n# none\n\n3 1 0 # counts\n", "3 1 3\n",
                             "# x\nOFF 3 1 0\n", "OFF\r\n3 1 0\r\n"}) {
    INFO(header);
    CHECK(same_mesh(read("a.off", header + body), kTriangle));
  }
}

TEST_CASE("ReadOff_ExtraColumns_ArePassedOver") {
  CHECK(same_mesh(read("a",
                       "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 0 0 0 1\n"
                       "3 0 1 2 0.5 0.5 0.5\n"),
                  kTriangle));
  CHECK(same_mesh(read("a", "STCNOFF 3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n"),
                  kTriangle));
}

TEST_CASE("ReadOff_BadFile_IsRefusedWithItsLine") {
  const auto file = [](const std::string& bytes) { return refused("a.off", bytes); };
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n";
  CHECK_THAT(file("4OFF\n3 1 0\n"), Contains("three dimensions"));
  CHECK_THAT(file("OFF BINARY\n"), Contains("expected ascii numbers, found 'BINARY'"));
  CHECK_THAT(file("OFX\n3 1 0\n"), Contains("expected OFF or a count of vertices, found 'OFX'"));
  CHECK_THAT(file("OFF\n"), Contains("a count of vertices, found the end of the file"));
  CHECK_THAT(file("OFF\n3 -1 0\n"), Contains("a count of faces, found '-1'"));
  CHECK_THAT(file("OFF\n3 1000000000000 0\n"), Contains("of at most 1073741824"));
  CHECK_THAT(file("OFF\n4294967295 1 0\n"), Contains("of at most 4294967294"));
  CHECK_THAT(file("OFF\n3 1 many\n"), Contains("'many'"));
  CHECK_THAT(file(head), Contains("line 5: vertex 2: expected all 3 of them, found the end"));
  CHECK_THAT(file(head + "0 nan 0\n3 0 1 2\n"), Contains("line 5: vertex 2") && Contains("'nan'"));
  CHECK_THAT(file(head + "0 1\n3 0 1 2\n"), Contains("found the end of the line"));
  CHECK_THAT(file(head + "0 1 0\n3 0 1 3\n"),
             Contains("line 6: face 0: expected a vertex below 3"));
  CHECK_THAT(file(head + "0 1 0\n3 0 1 -1\n"), Contains("'-1'"));
  CHECK_THAT(file(head + "0 1 0\n3 0 1\n"), Contains("found the end of the line"));
  CHECK_THAT(file(head + "0 1 0\n9000000000000000000 0 1 2\n"), Contains("the end of the line"));
  CHECK_THAT(file(head + "0 1 0\n2 0 1\n"), Contains("three corners or more, found '2'"));
  CHECK_THAT(file(head + "0 1 0\n3 0 1 2 red\n"), Contains("'red'"));
  CHECK_THAT(file(head + "0 1 0\n3 0 1 2\n3 0 1 2\n"), Contains("line 7: end: expected nothing"));
}
