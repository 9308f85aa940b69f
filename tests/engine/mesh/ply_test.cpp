#include <fmt/format.h>
#include <fmt/ranges.h>

#include <catch2/catch.hpp>

#include "mesh_files.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using shapes::refusal;

namespace {

const std::string kHead = "ply\nformat ascii 1.0\n";
const std::string kVertices =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kEnd = "end_header\n";
const std::string kBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

IndexedMesh read_text(const std::string& bytes, std::vector<std::string>* warnings = nullptr) {
  const MeshDirectory directory;
  return read_indexed_mesh(directory.file("mesh.ply", bytes), warnings);
}

std::string ply_refused(const std::string& bytes) {
  return refusal([&] { read_text(bytes); });
}

const IndexedMesh kPlyTriangle = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};

/// A file with properties of every type, with lists and unknown elements, in either byte order.
std::string motley_binary(bool big, bool faces_first) {
  const std::string header = std::string("ply\r\nformat ") +
                             (big ? "binary_big_endian" : "binary_little_endian") + " 1.0\r\n";
  const std::string vertices =
      "element vertex 4\r\nproperty uchar red\r\nproperty double z\r\n"
      "property list ushort short tags\r\nproperty int16 y\r\nproperty float32 x\r\n";
  const std::string odd = "element material 2\r\nproperty list uint8 float64 values\r\n";
  const std::string faces =
      "element face 2\r\nproperty list char char other\r\n"
      "property list uint uint16 vertex_index\r\nproperty int8 flag\r\n";
  std::string vertex_bytes, odd_bytes, face_bytes;
  for (int v = 0; v < 4; ++v) {
    append_number(vertex_bytes, std::uint8_t{200}, big);
    append_number(vertex_bytes, 0.125 * v, big);
    append_number(vertex_bytes, static_cast<std::uint16_t>(v), big);
    for (int tag = 0; tag < v; ++tag) append_number(vertex_bytes, std::int16_t{-1}, big);
    append_number(vertex_bytes, static_cast<std::int16_t>(-100 * v), big);
    append_number(vertex_bytes, 1.5f * static_cast<float>(v), big);
  }
  for (int m = 0; m < 2; ++m) {
    append_number(odd_bytes, static_cast<std::uint8_t>(m), big);
    for (int i = 0; i < m; ++i) append_number(odd_bytes, 7.0, big);
  }
  for (const std::vector<std::uint16_t>& corners :
       {std::vector<std::uint16_t>{0, 1, 2}, std::vector<std::uint16_t>{0, 3, 1}}) {
    append_number(face_bytes, std::int8_t{1}, big);
    append_number(face_bytes, std::int8_t{9}, big);
    append_number(face_bytes, static_cast<std::uint32_t>(corners.size()), big);
    for (const std::uint16_t corner : corners) append_number(face_bytes, corner, big);
    append_number(face_bytes, std::int8_t{-3}, big);
  }
  const std::string end = "end_header\r\n";
  return faces_first
             ? header + faces + odd + vertices + end + face_bytes + odd_bytes + vertex_bytes
             : header + vertices + odd + faces + end + vertex_bytes + odd_bytes + face_bytes;
}

}  // namespace

TEST_CASE("ReadPly_AnyTypesOrderAndUnknownParts_ReadsPositionsAndFaces") {
  const IndexedMesh expected = {
      {{0, 0, 0}, {1.5, -100, 0.125}, {3, -200, 0.25}, {4.5, -300, 0.375}}, {{0, 1, 2}, {0, 3, 1}}};
  for (const bool big : {false, true})
    for (const bool faces_first : {false, true}) {
      INFO("big endian " << big << ", faces first " << faces_first);
      CHECK(same_mesh(read_text(motley_binary(big, faces_first)), expected));
    }
}

TEST_CASE("ReadPly_EveryScalarType_IsReadInBothByteOrders") {
  const auto check = [](const char* type, auto number) {
    for (const bool big : {false, true}) {
      INFO(type << (big ? " big" : " little"));
      std::string bytes = std::string("ply\nformat ") +
                          (big ? "binary_big_endian" : "binary_little_endian") +
                          " 1.0\nelement vertex 3\n";
      for (const char* axis : {"x", "y", "z"})
        bytes += std::string("property ") + type + " " + axis + "\n";
      bytes += std::string("element face 1\nproperty list ") + type + " " + type +
               " vertex_indices\nend_header\n";
      using Number = decltype(number);
      for (int i = 0; i < 9; ++i)
        append_number(bytes, static_cast<Number>(number - Number(i)), big);
      for (const int i : {3, 0, 1, 2}) append_number(bytes, static_cast<Number>(i), big);
      const IndexedMesh mesh = read_text(bytes);
      CHECK(mesh.faces == kPlyTriangle.faces);
      for (int i = 0; i < 9; ++i)
        CHECK(mesh.positions[static_cast<std::size_t>(i / 3)][i % 3] ==
              static_cast<double>(static_cast<Number>(number - Number(i))));
    }
  };
  for (const char* type : {"char", "int8"}) check(type, std::int8_t{-100});
  for (const char* type : {"uchar", "uint8"}) check(type, std::uint8_t{255});
  for (const char* type : {"short", "int16"}) check(type, std::int16_t{-30000});
  for (const char* type : {"ushort", "uint16"}) check(type, std::uint16_t{65535});
  for (const char* type : {"int", "int32"}) check(type, std::int32_t{-2000000000});
  for (const char* type : {"uint", "uint32"}) check(type, std::uint32_t{4294967295u});
  for (const char* type : {"float", "float32"}) check(type, -0.1f);
  for (const char* type : {"double", "float64"}) check(type, 1e300);
}

TEST_CASE("ReadPly_AsciiVariants_AreRead") {
  CHECK(same_mesh(read_text(kHead + kVertices + kFaces + kEnd + kBody), kPlyTriangle));
  SECTION("carriage returns") {
    for (const std::string& line_end : {std::string("\r"), std::string("\r\n")}) {
      std::string bytes;
      for (const char c : kHead + kVertices + kFaces + kEnd + kBody)
        bytes += c == '\n' ? line_end : std::string(1, c);
      CHECK(same_mesh(read_text(bytes), kPlyTriangle));
    }
  }
  SECTION("blank lines, tabs, signs, exponents, no last line end") {
    CHECK(same_mesh(read_text(kHead + "\nobj_info by hand\n" + kVertices + kFaces + kEnd +
                              "\n+0 -0.0\t1e-400\n\n 1e0  0 0 \n0 1 0.0E+5\n\n3\t0 1 2"),
                    kPlyTriangle));
  }
  SECTION("lists among the vertices' properties") {
    CHECK(same_mesh(read_text(kHead +
                              "element vertex 3\nproperty list int float w\nproperty float z\n"
                              "property float y\nproperty float x\n" +
                              kFaces + kEnd + "0 0 0 0\n1 5 0 0 1\n2 5 6 0 1 0\n3 0 1 2\n"),
                    kPlyTriangle));
  }
  SECTION("elements without properties take no line") {
    CHECK(same_mesh(read_text(kHead + "element nothing 1000000000000000000\n" + kVertices + kFaces +
                              kEnd + kBody),
                    kPlyTriangle));
  }
}

TEST_CASE("ReadPly_AnotherListBeforeTheCorners_IsNotTakenForThem") {
  // The other list's only entry is a 3, and the bytes after it look like the rest of a face.
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty uchar x\n"
      "property uchar y\nproperty uchar z\nelement face 2\nproperty list uchar uchar other\n"
      "property list uchar uchar vertex_indices\nend_header\n";
  bytes.append(12, '\1');
  for (int face = 0; face < 2; ++face) bytes.append("\1\3\3\0\1\2", 6);
  CHECK(read_text(bytes).faces == shapes::Faces{{0, 1, 2}, {0, 1, 2}});
}

TEST_CASE("ReadPly_Polygons_AreFannedWithAWarning") {
  std::vector<std::string> warnings;
  const IndexedMesh mesh =
      read_text(kHead +
                    "element vertex 5\nproperty float x\nproperty float y\n"
                    "property float z\nelement face 2\n"
                    "property list uchar int vertex_indices\n" +
                    kEnd + "0 0 0\n1 0 0\n2 1 0\n1 2 0\n0 2 1\n5 4 3 2 1 0\n3 0 1 4\n",
                &warnings);
  CHECK(mesh.faces == shapes::Faces{{4, 3, 2}, {4, 2, 1}, {4, 1, 0}, {0, 1, 4}});
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0],
             Contains("mesh.ply: 1 faces of more than three corners divided into triangles"));
}

TEST_CASE("ReadPly_BytesAfterTheLastElement_AreIgnoredWithAWarning") {
  const std::string ascii = kHead + kVertices + kFaces + kEnd + kBody;
  const std::string rest(300000, '7');
  for (const std::string& bytes :
       {ascii + rest, zstd(ascii + rest), gzip(ascii + rest), motley_binary(false, false) + rest,
        motley_binary(true, true) + rest}) {
    std::vector<std::string> warnings;
    const IndexedMesh mesh = read_text(bytes, &warnings);
    CHECK(
        (same_mesh(mesh, kPlyTriangle) || same_mesh(mesh, read_text(motley_binary(false, false)))));
    CHECK_THAT(fmt::format("{}", fmt::join(warnings, "\n")),
               Contains("mesh.ply: 300000 bytes after the last element"));
  }
  std::vector<std::string> warnings;
  read_text(ascii + "\n \r\n", &warnings);
  CHECK(warnings.empty());
  // The reader reads the rest too, so that it detects a compressed file that was cut short there.
  const std::string whole = zstd(ascii + rest);
  CHECK_THAT(ply_refused(whole.substr(0, whole.size() - 5)), Contains("cut short"));
}

TEST_CASE("ReadPly_BadHeader_IsRefusedWithItsLine") {
  const std::string rest = kFaces + kEnd + kBody;
  CHECK_THAT(ply_refused("ply\nformat ascii 2.0\n" + kVertices + rest),
             Contains("line 2: header: expected 'format NAME 1.0', found '2.0'"));
  CHECK_THAT(ply_refused("ply\nformat utf8 1.0\n" + kVertices + rest), Contains("'utf8'"));
  CHECK_THAT(ply_refused("ply\n" + kVertices + rest),
             Contains("expected a format line, found none"));
  CHECK_THAT(ply_refused(kHead + "format ascii 1.0\n" + kVertices + rest), Contains("one format"));
  CHECK_THAT(ply_refused(kHead + "element vertex -3\n" + rest),
             Contains("line 3") && Contains("'-3'"));
  CHECK_THAT(ply_refused(kHead + "element vertex 3x\n" + rest), Contains("'3x'"));
  CHECK_THAT(ply_refused(kHead + "element vertex 99999999999999999999\n" + rest),
             Contains("expected a count of elements"));
  CHECK_THAT(ply_refused(kHead + "element vertex\n" + rest), Contains("found 2 words"));
  CHECK_THAT(ply_refused(kHead + "property float x\n" + rest), Contains("an element before"));
  CHECK_THAT(ply_refused(kHead + "elephant\n" + kVertices + rest), Contains("'elephant'"));
  CHECK_THAT(ply_refused(kHead + kVertices + "property half w\n" + rest), Contains("'half'"));
  CHECK_THAT(ply_refused(kHead + kVertices + "property list uchar w\n" + rest),
             Contains("4 words"));
  CHECK_THAT(ply_refused(kHead + kVertices + kVertices + rest), Contains("each element once"));
  CHECK_THAT(ply_refused(kHead + kVertices + "property int x\n" + rest),
             Contains("expected one vertex property x, found 2"));
  CHECK_THAT(ply_refused(kHead + "element vertex 3\nproperty float x\nproperty float y\n" + rest),
             Contains("expected one vertex property z, found 0"));
  CHECK_THAT(ply_refused(kHead +
                         "element vertex 3\nproperty list int float x\nproperty float y\n"
                         "property float z\n" +
                         rest),
             Contains("expected one vertex property x, found 0"));
  CHECK_THAT(ply_refused(kHead + rest), Contains("expected an element vertex, found none"));
  CHECK_THAT(ply_refused(kHead + kVertices + kEnd),
             Contains("expected an element face, found none"));
  CHECK_THAT(
      ply_refused(kHead + kVertices + "element face 1\nproperty list int int strips\n" + kEnd),
      Contains("expected one face list"));
  CHECK_THAT(ply_refused(kHead + kVertices),
             Contains("expected end_header, found the end of the file"));
  CHECK_THAT(ply_refused(kHead + "comment " + std::string(100000, 'x') + "\n"),
             Contains("lines of at most"));
}

TEST_CASE("ReadPly_HeaderPromisesTooMuch_IsRefusedAtOnce") {
  CHECK_THAT(
      ply_refused(kHead + kVertices +
                  "element face 1000000000000\nproperty list uchar int vertex_indices\n" + kEnd),
      Contains("expected at most 1073741824 faces, found 1000000000000"));
  CHECK_THAT(ply_refused(kHead +
                         "element vertex 4294967295\nproperty float x\nproperty float y\n"
                         "property float z\n" +
                         kFaces + kEnd),
             Contains("expected at most 4294967294 vertices"));
}

TEST_CASE("ReadPly_BadBody_IsRefusedWithItsPlace") {
  const std::string header = kHead + kVertices + kFaces + kEnd;
  const auto body = [&](const std::string& text) { return ply_refused(header + text); };
  CHECK_THAT(body("0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
             Contains("mesh.ply, line 11: 'vertex' 1: expected a finite position, found nan"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 inf 0\n3 0 1 2\n"), Contains("line 12") && Contains("inf"));
  CHECK_THAT(body("0 0 0\n1 0 1e999\n0 1 0\n3 0 1 2\n"), Contains("'1e999'"));
  CHECK_THAT(body("0 0 0\n1 0\n0 1 0\n3 0 1 2\n"),
             Contains("line 11: 'vertex' 1: expected a number, found the end of the line"));
  CHECK_THAT(body("0 0 0\n1 0 0 7\n0 1 0\n3 0 1 2\n"),
             Contains("expected the end of the line, found '7'"));
  CHECK_THAT(body("0 0 0\n1 0x1 0\n0 1 0\n3 0 1 2\n"), Contains("'0x1'"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
             Contains("line 13: 'face' 0: expected a vertex below 3, found 3"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n3 0 -1 2\n"), Contains("found -1"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n"), Contains("found 1.5"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n2 0 1\n"), Contains("three corners or more, found 2"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n"), Contains("a count for the list"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\n3.5 0 1 2\n"), Contains("a count for the list"));
  CHECK_THAT(body("0 0 0\n1 0 0\n0 1 0\nnan 0 1 2\n"), Contains("a count for the list"));
  CHECK_THAT(body("0 0 0\n1 0 0\n"), Contains("'vertex' 2: expected all 3 of them, found the end"));
  CHECK_THAT(body(std::string(5000, '1')), Contains("at most 4096 characters"));
}

TEST_CASE("ReadPly_BadBinaryBody_IsRefusedWithItsByte") {
  IndexedMesh mesh = shapes::octahedron();
  const std::string good = ply_binary(mesh, false);
  const std::size_t header = ply_header("binary_little_endian", 6, 8).size();
  SECTION("nan") {
    std::string bytes = good;
    bytes.replace(header + 2 * 12 + 4, 4, std::string("\x00\x00\xc0\x7f", 4));
    CHECK_THAT(ply_refused(bytes), Contains("byte " + std::to_string(header + 24)) &&
                                       Contains("'vertex' 2: expected a finite position"));
  }
  SECTION("index") {
    mesh.faces[5][1] = 6;
    CHECK_THAT(ply_refused(ply_binary(mesh, false)),
               Contains("byte " + std::to_string(header + 72 + 5 * 13 + 5)) &&
                   Contains("'face' 5: expected a vertex below 6, found 6"));
  }
  SECTION("negative index") {
    mesh.faces[5][1] = 0xfffffffe;
    CHECK_THAT(ply_refused(ply_binary(mesh, false)), Contains("found -2"));
  }
  SECTION("cut") {
    CHECK_THAT(ply_refused(good.substr(0, good.size() - 1)),
               Contains("'face' 7: expected all 8 of them, found the end of the file"));
  }
}
