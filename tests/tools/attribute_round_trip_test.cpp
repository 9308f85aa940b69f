// Attributes of every type go into a store and out of it, in any order of vertices, with the same
// bits.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "plait/extend/attributed_mesh.h"
#include "plait/mesh_io.h"
#include "support/shuffled_mesh.h"
#include "support/test_meshes.h"
#include "workplace.h"

namespace plait::test {
namespace {

namespace fs = std::filesystem;

struct Property {
  const char* type;
  const char* name;
  std::size_t bytes;
};

/// The properties of each attribute, with every type that PLY has.
struct OwnAttribute {
  const char* name;
  ComponentType type;
  std::vector<Property> properties;
};

const std::vector<OwnAttribute>& own_attributes() {
  static const std::vector<OwnAttribute> all = {
      {"normal",
       ComponentType::kFloat32,
       {{"float", "nx", 4}, {"float", "ny", 4}, {"float", "nz", 4}}},
      {"color",
       ComponentType::kUint8,
       {{"uchar", "red", 1}, {"uchar", "green", 1}, {"uchar", "blue", 1}, {"uchar", "alpha", 1}}},
      {"texture", ComponentType::kFloat32, {{"float", "s", 4}, {"float", "t", 4}}},
      {"height", ComponentType::kFloat64, {{"double", "height", 8}}},
      {"quality", ComponentType::kFloat32, {{"float", "quality", 4}}},
      {"label", ComponentType::kInt32, {{"int", "label", 4}}},
      {"part", ComponentType::kUint32, {{"uint", "part", 4}}},
      {"depth", ComponentType::kInt16, {{"short", "depth", 2}}},
      {"count", ComponentType::kUint16, {{"ushort", "count", 2}}},
      {"side", ComponentType::kInt8, {{"char", "side", 1}}},
      {"mark", ComponentType::kUint8, {{"uchar", "mark", 1}}},
      {"flow",
       ComponentType::kFloat32,
       {{"float", "flow_0", 4}, {"float", "flow_1", 4}, {"float", "flow_2", 4}}},
  };
  return all;
}

/// A number of a type, in the bytes of the file. Only numbers: the bits of others have no promise.
std::string random_number(const Property& property, std::mt19937& random) {
  std::uint64_t bits = (std::uint64_t{random()} << 32) | random();
  const std::string type = property.type;
  if (type == "float") {
    static constexpr std::array<float, 3> kRare = {-0.0F, 1e-42F, -3.4e38F};
    const float number = random() % 8 == 0
                             ? kRare[random() % 3]
                             : static_cast<float>(static_cast<std::int32_t>(bits)) / 7;
    std::memcpy(&bits, &number, sizeof number);
  }
  if (type == "double") {
    const double number = random() % 8 == 0 ? -5e-324 : static_cast<double>(bits) / 7;
    std::memcpy(&bits, &number, sizeof number);
  }
  std::string bytes(property.bytes, '\0');
  std::memcpy(bytes.data(), &bits, bytes.size());
  return bytes;
}

/// A mesh, and for each vertex the bytes of all own attributes, in their order.
struct FineMesh {
  IndexedMesh mesh;
  std::vector<std::string> records;

  /// Does not use the writer of the program.
  void write(const fs::path& path) const {
    std::ofstream file(path, std::ios::binary);
    file << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.positions.size()
         << "\nproperty float x\nproperty float y\nproperty float z\n";
    for (const OwnAttribute& attribute : own_attributes())
      for (const Property& property : attribute.properties)
        file << "property " << property.type << ' ' << property.name << '\n';
    file << "element face " << mesh.faces.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (std::size_t vertex = 0; vertex < records.size(); ++vertex) {
      const Vector3<double>& p = mesh.positions[vertex];
      const std::array<float, 3> narrow = {static_cast<float>(p.x), static_cast<float>(p.y),
                                           static_cast<float>(p.z)};
      file.write(reinterpret_cast<const char*>(narrow.data()), sizeof narrow);
      file << records[vertex];
    }
    for (const auto& face : mesh.faces) {
      file << '\3';
      file.write(reinterpret_cast<const char*>(face.data()), sizeof face);
    }
  }
  /// Positions are different at all vertices.
  std::map<std::array<double, 3>, std::string> by_position() const {
    std::map<std::array<double, 3>, std::string> result;
    for (std::size_t vertex = 0; vertex < records.size(); ++vertex) {
      const Vector3<double>& p = mesh.positions[vertex];
      result[{p.x, p.y, p.z}] = records[vertex];
    }
    return result;
  }
};

FineMesh read_fine_mesh(const fs::path& path) {
  std::vector<std::string> warnings;
  AttributedMesh read = read_attributed_mesh(path, &warnings);
  CHECK(warnings.empty());
  FineMesh fine{std::move(read.mesh), {}};
  fine.records.resize(fine.mesh.positions.size());
  for (const OwnAttribute& own : own_attributes()) {
    CAPTURE(own.name);
    const auto found = std::ranges::find(read.attributes, std::string(own.name),
                                         [](const MeshAttribute& a) { return a.schema.name; });
    REQUIRE(found != read.attributes.end());
    CHECK(found->schema.type == own.type);
    REQUIRE(found->schema.components == own.properties.size());
    const std::size_t bytes = found->schema.record_bytes();
    for (std::size_t vertex = 0; vertex < fine.records.size(); ++vertex)
      fine.records[vertex].append(
          reinterpret_cast<const char*>(found->records.data()) + vertex * bytes, bytes);
  }
  CHECK(read.attributes.size() == own_attributes().size());
  return fine;
}

}  // namespace

TEST_CASE("Import_AttributesOfEveryType_ComeOutOfTheStoreWithTheSameBits") {
  for (const IndexedMesh& mesh : {torus_grid(6, 5), sheet(5, 4)}) {
    const Workplace here;
    write_ply(here.path("mesh.ply"), mesh);
    here.succeed({"subdivide", "mesh.ply", "smooth.plait", "--levels", "2"});
    here.succeed({"export", "smooth.plait", "smooth.ply"});
    FineMesh fine{read_indexed_mesh(here.path("smooth.ply")), {}};
    std::mt19937 random(17);
    for (std::size_t vertex = 0; vertex < fine.mesh.positions.size(); ++vertex) {
      std::string& record = fine.records.emplace_back();
      for (const OwnAttribute& attribute : own_attributes())
        for (const Property& property : attribute.properties)
          record += random_number(property, random);
    }
    const auto expected = fine.by_position();
    REQUIRE(expected.size() == fine.records.size());

    std::string names;
    for (const OwnAttribute& attribute : own_attributes())
      names += (names.empty() ? "" : ",") + std::string(attribute.name);
    for (const unsigned turn : {1U, 2U}) {
      std::vector<VertexId> former;
      FineMesh other{shuffled(fine.mesh, turn, &former), {}};
      for (const VertexId vertex : former) other.records.push_back(fine.records[vertex]);
      REQUIRE(other.by_position() == expected);
      other.write(here.path("fine.ply"));
      here.succeed({"import", "fine.ply", "s.plait", "--force"});
      here.succeed({"export", "s.plait", "out.ply", "--attribute", names, "--force"});
      fine = read_fine_mesh(here.path("out.ply"));
      CHECK(fine.mesh.faces.size() == mesh.faces.size() * 16);
      CHECK(fine.by_position() == expected);
    }
  }
}

}  // namespace plait::test
