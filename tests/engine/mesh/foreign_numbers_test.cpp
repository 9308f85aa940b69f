// Numbers as old run-time systems and Fortran print them, in every text format.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "mesh/files/text_input.h"
#include "mesh_files.h"
#include "plait/extend/attributed_mesh.h"

using namespace plait;
using namespace plait::mesh_files;

TEST_CASE("ParseNumber_ForeignForms_AreRead") {
  for (const char* word : {"1.#QNAN", "-1.#IND00", "1.#SNAN0", "-1.#J", "1.#R", "1.#QO", "1.$",
                           "1.#IND00e+000", "nan(ind)", "-nan(ind)", "NaNQ", "-NaN"}) {
    INFO(word);
    REQUIRE(parse_number(word).has_value());
    CHECK(std::isnan(*parse_number(word)));
  }
  CHECK(parse_number("1.#INF") == INFINITY);
  CHECK(parse_number("-1.#INF000") == -INFINITY);
  CHECK(parse_number("+1.#INFe+000") == INFINITY);
  CHECK(parse_number("1.5D+03") == 1500.0);
  CHECK(parse_number("-.25d2") == -25.0);
  CHECK(parse_number("0.15-102") == 0.15e-102);
  CHECK(parse_number("1.5Q1") == 15.0);
  for (const char* word : {"1.#", "1.#INFO", "1.#5", "d3", "1.5D", "1.5D+", "5-102", "1.5-12",
                           "1,5", "1.#QNANx", "nanq1", "0x1D3"}) {
    INFO(word);
    CHECK(!parse_number(word).has_value());
  }
}

TEST_CASE("ReadMesh_NumbersOfOldWindows_AreNotFiniteInEveryTextFormat") {
  const MeshDirectory directory;
  // In OBJ and OFF the mark must not begin a comment: that would leave the number 1.
  const std::string vertices = "{0}0 0 1.#INF\n{0}1 0 1.#J # note\n{0}0 1 2.5D0# note\n";
  const auto read = [&](const char* name, const std::string& bytes) {
    return read_attributed_mesh(directory.file(name, bytes), nullptr, NotFinite::kKeep).mesh;
  };
  const std::string stl =
      "solid s\nfacet normal -1.#IND -1.#IND -1.#IND\nouter loop\nvertex 0 0 1.#INF\nvertex 1 0 "
      "1.#J\nvertex 0 1 2.5D0\nendloop\nendfacet\nendsolid s\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 1.#INF\n1 0 "
      "1.#J\n0 1 2.5D0\n3 0 1 2\n";
  for (const IndexedMesh& mesh :
       {read("a.obj", fmt::format(fmt::runtime(vertices), "v ") + "f 1 2 3\n"),
        read("a.off", "OFF\n3 1 0\n" + fmt::format(fmt::runtime(vertices), "") + "3 0 1 2\n"),
        read("a.stl", stl), read("a.ply", ply)}) {
    REQUIRE(mesh.positions.size() == 3);
    CHECK(mesh.positions[0].z == INFINITY);
    CHECK(std::isnan(mesh.positions[1].z));
    CHECK(mesh.positions[2].z == 2.5);
  }
}
