// What readers leave out is named with its numbers.
#include <catch2/catch.hpp>

#include "mesh_files.h"
#include "plait/extend/attributed_mesh.h"

using namespace plait;
using namespace plait::mesh_files;
using Catch::Contains;
using Catch::EndsWith;

namespace {

std::string left_out(const std::string& name, const std::string& bytes, bool attributes = true) {
  const MeshDirectory directory;
  std::vector<std::string> warnings;
  if (attributes)
    read_attributed_mesh(directory.file(name, bytes), &warnings);
  else
    read_base_mesh(directory.file(name, bytes), &warnings);
  for (const std::string& warning : warnings)
    if (warning.find(": left out: ") != std::string::npos) return warning;
  return "";
}

const std::string kPlyVertices =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string kPlyFaces = "element face 1\nproperty list uchar int vertex_indices\n";

}  // namespace

TEST_CASE("ReadObj_ColoursTextureAndTags_AreNamed") {
  const std::string text = left_out(
      "a.obj",
      "mtllib a.mtl\no part\nv 0 0 0 0.25 0.5 1\nv 1 0 0 0.25 0.5 1\nv 0 1 0 1\nv 0 1 1 0.5\n"
      "vt 0 0\nvt 1 0\nvn 0 0 1\ng one\ng two\nusemtl skin\ns 1\nt crease 2/1/0 0 1 5.0\nt corner "
      "1/1/0 2 3\nl 1 2\nf 1/1 2/2 3/1\nf 2 4 3\n");
  for (const char* part :
       {"a.obj: left out: ", "colours of 2 vertices", "weights of 1 vertex;",
        "2 texture coordinates", "1 normal;", "2 tags (t crease and its like)", "2 groups",
        "1 object name;", "1 use of a material;", "1 material library", "1 line element", "PLY"})
    CHECK_THAT(text, Contains(part));
  const std::string lines = left_out("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n");
  CHECK_THAT(lines, EndsWith("c.obj: left out: 1 line element"));
  CHECK(left_out("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ns off\nf 1 2 3\n").empty());
}

TEST_CASE("ReadObj_OtherFilesAndCommands_AreNamed") {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  CHECK_THAT(left_out("a.obj", text + "call part.obj\ncall rest.obj\ncsh ls\n"),
             Contains("left out: 2 calls of other files, which were not read; "
                      "1 command of a shell, which was not run"));
}

TEST_CASE("ReadObj_ColoursInComments_AreNamed") {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK_THAT(left_out("a.obj", vertices + "f 1 2 3\n#MRGB ffffffffffff0000\n" +
                                   "#MRGB ff00ff00\n# MRGB is no block\n"),
             Contains("left out: colours and masks in comments (#MRGB) of 3 vertices"));
  CHECK(left_out("b.obj", "#MR\n" + vertices + "f 1 2 3\n# ffffffffffff0000\n#MRGB").empty());
}

TEST_CASE("ReadOff_NumbersBesideAPosition_AreNamed") {
  const std::string rest =
      "3 1 0\n0 0 0 9 9 9 9\n1 0 0 9 9 9 9\n0 1 0 9 9 9 9\n3 0 1 2 0.5 0.5 1\n";
  CHECK_THAT(left_out("a.off", "COFF\n" + rest),
             Contains("colours of 3 vertices; colours of 1 face ("));
  CHECK_THAT(left_out("a.off", "OFF\n" + rest), Contains("colours of 3 vertices"));
  CHECK_THAT(left_out("a.off", "STNOFF\n" + rest),
             Contains("texture coordinates and normals of 3 vertices; ") && Contains("a PLY file"));
  // No PLY file would keep numbers of faces.
  CHECK_THAT(left_out("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n"),
             EndsWith("left out: colours of 1 face"));
}

TEST_CASE("ReadPly_WhatIsNoAttribute_IsNamed") {
  const std::string head =
      "ply\nformat ascii 1.0\ncomment TextureFile my skin.png\n" + kPlyVertices +
      "property uchar red\nproperty uchar green\nproperty uchar blue\n" + kPlyFaces +
      "property list uchar float texcoord\nproperty int texnumber\nelement edge 2\nproperty int "
      "vertex1\nproperty int vertex2\nend_header\n0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n"
      "3 0 1 2 6 0 0 1 0 0 1 0\n0 1\n1 2\n";
  const std::string with = left_out("a.ply", head);
  for (const char* part :
       {"properties texcoord, texnumber of 1 face", "2 elements edge", "texture file my skin.png"})
    CHECK_THAT(with, Contains(part));
  CHECK_THAT(with, !Contains("red") && !Contains("are kept"));
  CHECK_THAT(
      left_out("c.ply", "ply\nformat ascii 1.0\n" + kPlyVertices + "property list uchar int of\n" +
                            kPlyFaces + "end_header\n0 0 0 0\n1 0 0 0\n0 1 0 0\n3 0 1 2\n"),
      Contains("of of 3 vertices (scalar properties of vertices are kept)"));
  const std::string twice =
      left_out("d.ply", "ply\nformat ascii 1.0\n" + kPlyVertices +
                            "property float q\nproperty float q\nproperty uchar nx\nproperty "
                            "uchar nx\n" +
                            kPlyFaces +
                            "end_header\n0 0 0 1 2 3 4\n1 0 0 1 2 3 4\n0 1 0 1 2 3 4\n3 0 1 2\n");
  CHECK_THAT(twice, Contains("second ones of a name") && Contains(": q, nx of 3 vertices"));
  const std::string without = left_out("a.ply", head, false);
  CHECK_THAT(without, Contains("properties red, green, blue of 3 vertices; ") &&
                          Contains("only positions and faces are read here"));
  CHECK(left_out("b.ply", "ply\nformat ascii 1.0\n" + kPlyVertices + kPlyFaces +
                              "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
            .empty());
}

TEST_CASE("ReadOff_CountsBehindTheKeywordWithoutABlank_AreRead") {
  const MeshDirectory directory;
  for (const char* header : {"OFF3 1 0\n", "COFF3 1 0\n", "OFF3\n1\n", "STCNOFF3 1\n"}) {
    INFO(header);
    const IndexedMesh mesh = read_indexed_mesh(
        directory.file("a", std::string(header) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    CHECK(mesh.positions.size() == 3);
    CHECK(mesh.faces.size() == 1);
  }
}

TEST_CASE("ReadGzip_ZerosBehindTheLastMember_ArePadding") {
  const MeshDirectory directory;
  std::string text;
  for (int i = 0; i < 40000; ++i) text += "v " + std::to_string(i) + " 0.5 0\n";
  text += "f 1 2 3\n";
  for (const std::string& whole :
       {gzip("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), gzip(text),
        gzip(text.substr(0, 100)) + gzip(text.substr(100)), gzip(text) + gzip("")}) {
    const IndexedMesh wanted = read_indexed_mesh(directory.file("a.obj.gz", whole));
    for (const std::size_t zeros : {1u, 2u, 3u, 4u, 9u, 512u, 70000u}) {
      INFO(zeros);
      CHECK(same_mesh(
          read_indexed_mesh(directory.file("b.obj.gz", whole + std::string(zeros, '\0'))), wanted));
    }
    CHECK_THROWS_AS(read_indexed_mesh(directory.file(
                        "c.obj.gz", whole.substr(0, whole.size() - 12) + std::string(512, '\0'))),
                    Error);
    CHECK_THROWS_AS(read_indexed_mesh(directory.file("c.obj.gz", whole + "words")), Error);
  }
}
