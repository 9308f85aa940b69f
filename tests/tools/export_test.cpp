#include <fmt/format.h>

#include <boost/iostreams/copy.hpp>
#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filter/zstd.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#include "export/mesh_format.h"
#include "plait/mesh_io.h"
#include "plait/notes.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

constexpr int kLevel = 2;

struct ExportWorkplace : Workplace {
  BaseMesh base;
  explicit ExportWorkplace(const IndexedMesh& mesh) : base(BaseMesh::build(mesh)) {
    write_ply(directory.path() / "mesh.ply", mesh);
    succeed({"subdivide", "mesh.ply", "s.plait", "--levels", "3", "--normals", "--block", "4K"});
  }
  std::filesystem::path write(const std::string& name, const Words& options = {}) const {
    succeed({"export", "s.plait", name, "--level", std::to_string(kLevel)}, options);
    return path(name);
  }
};

std::string decompressed_content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  boost::iostreams::filtering_istream stream;
  if (path.extension() == ".gz") stream.push(boost::iostreams::gzip_decompressor());
  if (path.extension() == ".zst") stream.push(boost::iostreams::zstd_decompressor());
  stream.push(file);
  std::ostringstream content;
  boost::iostreams::copy(stream, content);
  return content.str();
}

struct Facet {
  Vector3<float> normal, corners[3];
};

std::vector<Facet> facets_of(const std::string& stl) {
  std::uint32_t count = 0;
  REQUIRE(stl.size() >= 84);
  std::memcpy(&count, stl.data() + 80, 4);
  REQUIRE(stl.size() == 84 + std::size_t{50} * count);
  std::vector<Facet> facets(count);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&facets[i], stl.data() + 84 + 50 * i, sizeof(Facet));
  return facets;
}

Vector3<double> to_float(const Vector3<double>& p) {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

void check_counts(const BaseMesh& read, const BaseMesh& base) {
  const LevelCounts expected = counts_at_level(base, kLevel);
  CHECK(read.vertex_count() == expected.vertices);
  CHECK(read.edge_count() == expected.edges);
  CHECK(read.face_count() == expected.faces);
  CHECK(read.border_edge_count() == base.border_edge_count() << kLevel);
}

}  // namespace

TEST_CASE("ExportFormat_NamesOfAnyKind_AreFormatsOrRefused") {
  CHECK(export_format("a.ply").mesh == MeshFormat::kPly);
  CHECK(export_format("a.obj.gz").mesh == MeshFormat::kObj);
  CHECK(export_format("a.obj.gz").compression == StreamCompression::kGzip);
  CHECK(export_format("d/a.b.stl.zst").mesh == MeshFormat::kStl);
  CHECK(export_format("a.off.gz").mesh == MeshFormat::kOff);
  CHECK(export_format("a.PVTP").mesh == MeshFormat::kPvtp);
  CHECK(export_format("a.glb").mesh == MeshFormat::kGlb);
  for (const char* name : {"a", "a.vtp.gz", "a.gz", "ply", "a.ply.bz2", "a.ply/", ".ply"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(export_format(name), Error);
  }
}

TEST_CASE("Export_PlyAndObjOfAnyMesh_ReadBackWithTheCountsOfTheLevel") {
  for (const IndexedMesh& mesh : {icosahedron(), seven_vertex_torus(), sheet(4, 3),
                                  single_triangle(), two_components(), random_sphere(3, 100)}) {
    const ExportWorkplace here(mesh);
    CAPTURE(here.base.vertex_count());
    Words warnings;
    const BaseMesh ply = read_base_mesh(here.write("out.ply"), &warnings);
    check_counts(ply, here.base);
    for (const char* name : {"out.ply.gz", "out.ply.zst", "out.obj", "out.obj.gz", "out.obj.zst",
                             "out.off", "out.off.zst"}) {
      CAPTURE(name);
      const BaseMesh read = read_base_mesh(here.write(name), &warnings);
      // A float written as decimals and read as a double rounds to the same float.
      CHECK(std::ranges::equal(read.positions(), ply.positions(), {}, to_float));
      CHECK(std::ranges::equal(read.faces(), ply.faces()));
    }
    CHECK(warnings.empty());
  }
}

TEST_CASE("Export_VerticesOfAFile_ComeByLevelSoThatTheBaseIsAPrefix") {
  const ExportWorkplace here(icosahedron());
  const IndexedMesh fine = read_indexed_mesh(here.write("fine.ply"));
  const Outcome coarse = here.succeed({"export", "s.plait", "coarse.ply", "--level", "0"});
  const IndexedMesh base = read_indexed_mesh(here.path("coarse.ply"));
  REQUIRE(base.positions.size() == 12);
  CHECK(base.faces.size() == 20);
  CHECK(std::equal(base.positions.begin(), base.positions.end(), fine.positions.begin()));
}

TEST_CASE("Export_NormalsAskedFor_AreWrittenAndPointOutwards") {
  const ExportWorkplace here(icosahedron());
  const std::string ply = decompressed_content_of(here.write("n.ply", {"--attribute", "normal"}));
  CHECK(ply.find("property float nx\nproperty float ny\nproperty float nz\n") != std::string::npos);
  const std::size_t start = ply.find("end_header\n") + 11;
  for (std::size_t vertex = 0; vertex < counts_at_level(here.base, kLevel).vertices; ++vertex) {
    Vector3<float> record[2];
    std::memcpy(record, ply.data() + start + vertex * sizeof(record), sizeof(record));
    CHECK(dot(record[1], record[1]) == Approx(1).epsilon(1e-5));
    CHECK(dot(record[0], record[1]) > 0);
  }
  const std::string obj = decompressed_content_of(here.write("n.obj", {"--attribute", "normal"}));
  CHECK(obj.find("\nvn ") != std::string::npos);
  CHECK(obj.find("//") != std::string::npos);
  CHECK(here.plait({"export", "s.plait", "n.stl", "--attribute", "normal"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "x.ply", "--attribute", "colour"}).status == 2);
}

TEST_CASE("Export_FaceAttributesAskedFor_AreNumbersOfTheTriangles") {
  const ExportWorkplace here(icosahedron());
  {
    Store store = Store::open(here.path("s.plait"), {.writable = true}, default_backends());
    store.notes().add_face_attribute({"material", ComponentType::kUint16, 1});
    store.notes().add_face_attribute({"part", ComponentType::kUint8, 1});
    for (std::uint16_t face = 0; face < 20; ++face) {
      store.notes().face_records<std::uint16_t>("material")[face] =
          static_cast<std::uint16_t>(1000 + face);
      store.notes().face_records<std::uint8_t>("part")[face] = static_cast<std::uint8_t>(face % 3);
    }
    store.notes().set_text("unit", "mm");
    store.commit();
  }
  const std::string ply = decompressed_content_of(
      here.write("f.ply", {"--face-attribute", "material,part", "--attribute", "normal"}));
  const std::string header = "property ushort material\nproperty uchar part\nend_header\n";
  const std::size_t start = ply.find(header);
  REQUIRE(start != std::string::npos);
  const LevelCounts counts = counts_at_level(here.base, kLevel);
  const std::size_t triangles = start + header.size() + counts.vertices * 24;
  REQUIRE(ply.size() == triangles + counts.faces * 16);
  for (std::size_t triangle = 0; triangle < counts.faces; ++triangle) {
    std::uint16_t material = 0;
    std::memcpy(&material, ply.data() + triangles + 16 * triangle + 13, 2);
    const auto face = triangle >> (2 * kLevel);
    REQUIRE(material == 1000 + face);
    REQUIRE(static_cast<std::uint8_t>(ply[triangles + 16 * triangle + 15]) == face % 3);
  }
  Words warnings;
  check_counts(read_base_mesh(here.path("f.ply"), &warnings), here.base);

  // Of some patches, one of them named twice. In VTK files, the array follows its length.
  const std::size_t part[] = {3, 5, 6}, count = std::size(part) << (2 * kLevel);
  const std::string some = decompressed_content_of(
      here.write("p.ply", {"--face-attribute", "material", "--faces", "5-6,3,5"}));
  const std::string vtk = decompressed_content_of(
      here.write("p.vtp", {"--face-attribute", "material", "--faces", "5-6,3,5"}));
  const std::size_t appended = vtk.find("\n_") + 2;
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, vtk.data() + appended, sizeof(bytes));
  REQUIRE(bytes == 2 * count);
  CHECK(some.find(fmt::format("element face {}\n", count)) != std::string::npos);
  for (std::size_t triangle = 0; triangle < count; ++triangle) {
    std::uint16_t material = 0;
    std::memcpy(&material, some.data() + some.size() - 15 * (count - triangle) + 13, 2);
    REQUIRE(material == 1000 + part[triangle >> (2 * kLevel)]);
    std::memcpy(&material, vtk.data() + appended + sizeof(bytes) + 2 * triangle, 2);
    REQUIRE(material == 1000 + part[triangle >> (2 * kLevel)]);
  }
  for (const char* name : {"f.obj", "f.stl"})
    CHECK(here.plait({"export", "s.plait", name, "--face-attribute", "part"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "x.ply", "--face-attribute", "colour"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "x.ply", "--face-attribute", "part,part"}).status == 2);

  // Copies have them, and info shows them.
  here.succeed({"convert", "s.plait", "t.plait", "--backend", "pread"});
  const nlohmann::json info = here.report({"info", "t.plait"});
  CHECK(info["texts"]["unit"] == "mm");
  CHECK(info["face_attributes"][0]["name"] == "material");
  CHECK(here.plait({"info", "t.plait"})
            .output.find("text       unit: mm\n"
                         "faces      material: uint16\n") != std::string::npos);
}

TEST_CASE("Export_StlOfAClosedMesh_HasEveryEdgeTwiceAndOuterNormals") {
  const ExportWorkplace here(icosahedron());
  for (const char* name : {"out.stl", "out.stl.gz", "out.stl.zst"}) {
    CAPTURE(name);
    const std::vector<Facet> facets = facets_of(decompressed_content_of(here.write(name)));
    CHECK(facets.size() == counts_at_level(here.base, kLevel).faces);
    using Point = std::array<float, 3>;
    const auto key = [](const Vector3<float>& p) { return Point{p.x, p.y, p.z}; };
    std::map<std::pair<Point, Point>, int> directed;
    for (const Facet& facet : facets) {
      CHECK(dot(facet.normal, facet.corners[0]) > 0);
      for (int side = 0; side < 3; ++side)
        ++directed[{key(facet.corners[side]), key(facet.corners[(side + 1) % 3])}];
    }
    for (const auto& [edge, count] : directed) {
      CHECK(count == 1);
      CHECK(directed.count({edge.second, edge.first}) == 1);
    }
  }
}

TEST_CASE("Export_LevelThatIsNotThere_IsRefusedAndLeavesNothing") {
  const ExportWorkplace here(icosahedron());
  const auto before = here.names();
  CHECK(here.plait({"export", "s.plait", "out.ply", "--level", "4"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "out.dae"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "s.plait"}).status == 2);
  CHECK(here.plait({"export", "s.plait", "no/out.ply"}).status == 2);
  CHECK(here.names() == before);
}

TEST_CASE("Export_FileThatExists_IsReplacedByForceAlone") {
  const ExportWorkplace here(icosahedron());
  const auto content = [&](const char* name) {
    return decompressed_content_of(here.directory.path() / name);
  };
  for (const char* name : {"out.ply", "out_0.vtp", "out.bin"})
    std::ofstream(here.directory.path() / name) << "mine";
  for (const char* name : {"out.ply", "out.pvtp", "out.gltf"}) {
    CAPTURE(name);
    const auto before = here.names();
    const Outcome refused = here.plait({"export", "s.plait", name});
    CHECK(refused.status == 2);
    CHECK(refused.errors.find("exists already") != std::string::npos);
    CHECK(here.names() == before);
  }
  for (const char* name : {"out.ply", "out_0.vtp", "out.bin"}) CHECK(content(name) == "mine");
  for (const char* name : {"out.ply", "out.pvtp", "out.gltf"})
    CHECK(here.plait({"export", "s.plait", name, "--force"}).status == 0);
  for (const char* name : {"out.ply", "out_0.vtp", "out.bin"}) CHECK(content(name) != "mine");
}

TEST_CASE("Export_NamesThatAreNoUtf8_AreReportedOrRefusedWhereAFileWouldNameThem") {
  const ExportWorkplace here(icosahedron());
  for (const char* name : {"Gel\xe4nde.ply", "Gel\xe4nde.vtp", "Gel\xe4nde.glb"}) {
    const Outcome outcome = here.plait({"export", "s.plait", name, "--json"});
    CAPTURE(name, outcome.errors);
    REQUIRE(outcome.status == 0);
    CHECK(outcome.json()["vertices"].is_number());
    CHECK(std::filesystem::exists(here.directory.path() / name));
  }
  const auto before = here.names();
  for (const char* name : {"Gel\xe4nde.pvtp", "Gel\xe4nde.gltf", "a\nb.pvtp"}) {
    const Outcome outcome = here.plait({"export", "s.plait", name, "--json"});
    CHECK(outcome.status == 2);
    CHECK(outcome.errors.find("UTF-8") != std::string::npos);
  }
  CHECK(here.names() == before);
}

TEST_CASE("Export_RefinedBaseMesh_StartsAtTheBaseLevel") {
  const ExportWorkplace here(icosahedron());
  here.succeed({"subdivide", "mesh.ply", "r.plait", "--levels", "3", "--max-slot", "12"});
  here.succeed({"export", "r.plait", "r.ply"});
  here.succeed({"export", "s.plait", "s.ply"});
  const BaseMesh refined = read_base_mesh(here.path("r.ply"));
  const BaseMesh plain = read_base_mesh(here.path("s.ply"));
  CHECK(refined.vertex_count() == plain.vertex_count());
  // With other base vertices, sums run in another order. So the positions are equal except for
  // rounding.
  for (const Vector3<double>& point : refined.positions()) {
    double nearest = 1;
    for (const Vector3<double>& other : plain.positions())
      nearest = std::min(nearest, dot(other - point, other - point));
    CHECK(nearest < 1e-12);
  }
  CHECK(here.plait({"export", "r.plait", "x.ply", "--level", "0"}).status == 2);
}

}  // namespace plait::test
