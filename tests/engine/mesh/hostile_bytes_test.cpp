// Files that end at any byte, and files with random changes. The result must be a named error or a
// mesh that satisfies every relation.

#include <catch2/catch.hpp>
#include <random>

#include "mesh_files.h"
#include "shapes.h"

using namespace plait;
using namespace plait::mesh_files;

namespace {

enum class Outcome { kMesh, kError };

Outcome read_hostile(const std::filesystem::path& path) {
  try {
    shapes::check_topology(read_base_mesh(path));
    return Outcome::kMesh;
  } catch (const Error& error) {
    const std::string message = error.what();
    const bool named = error.code() == ErrorCode::kInvalidArgument &&
                       message.find(path.filename().string()) != message.npos &&
                       message.find('\n') == message.npos && message.size() < 1000;
    if (!named) FAIL("not a named error: " << message);
    return Outcome::kError;
  }
}

std::vector<Sample> compressed_samples(const IndexedMesh& mesh) {
  std::vector<Sample> result;
  for (const Sample& sample : samples(mesh)) {
    result.push_back({sample.name + ".gz", gzip(sample.bytes), false});
    result.push_back({sample.name + ".zst", zstd(sample.bytes), false});
  }
  return result;
}

}  // namespace

TEST_CASE("ReadBaseMesh_FileCutAnywhere_IsRefusedOrStillAMesh") {
  const MeshDirectory directory;
  for (const Sample& sample : samples(shapes::octahedron())) {
    std::size_t meshes = 0;
    for (std::size_t length = 0; length < sample.bytes.size(); ++length)
      if (read_hostile(directory.file(sample.name, sample.bytes.substr(0, length))) ==
          Outcome::kMesh)
        ++meshes;
    INFO(sample.name << ": " << meshes << " cuts leave a mesh");
    if (sample.name == "text.obj")
      CHECK(meshes > 8);  // each whole line ends a valid file
    else if (sample.ascii)
      CHECK(meshes == 1);  // the last line end may be missing
    else
      CHECK(meshes == 0);
  }
}

TEST_CASE("ReadBaseMesh_CompressedFileCutAnywhere_IsRefused") {
  const MeshDirectory directory;
  for (const Sample& sample : compressed_samples(shapes::octahedron()))
    for (std::size_t length = 0; length < sample.bytes.size(); ++length) {
      INFO(sample.name << " cut at " << length);
      REQUIRE(read_hostile(directory.file(sample.name, sample.bytes.substr(0, length))) ==
              Outcome::kError);
    }
}

TEST_CASE("ReadBaseMesh_RandomBytesChanged_IsRefusedOrStillAMesh") {
  const MeshDirectory directory;
  const IndexedMesh mesh = shapes::torus(3, 4);
  std::vector<Sample> all = samples(mesh);
  for (Sample& sample : compressed_samples(mesh)) all.push_back(std::move(sample));
  std::mt19937 random(12345);
  for (const Sample& sample : all) {
    std::size_t errors = 0;
    const int rounds = sample.name.ends_with(".ply") || sample.ascii ? 2000 : 300;
    for (int round = 0; round < rounds; ++round) {
      std::string bytes = sample.bytes;
      for (std::size_t changes = 1 + random() % 3; changes > 0; --changes) {
        const std::size_t at = random() % bytes.size();
        switch (random() % 3) {
          case 0:
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
            break;
          case 1:
            bytes[at] = static_cast<char>(random());
            break;
          default:
            bytes.erase(at, 1 + random() % 4);
        }
        if (bytes.empty()) break;
      }
      INFO(sample.name << ", round " << round);
      if (read_hostile(directory.file(sample.name, bytes)) == Outcome::kError) ++errors;
    }
    INFO(sample.name << ": " << errors << " of " << rounds << " refused");
    CHECK(errors > 0);
  }
}

TEST_CASE("ReadBaseMesh_RandomWords_AreRefusedOrAMesh") {
  const MeshDirectory directory;
  const std::vector<std::string> words = {"ply",
                                          "format ascii 1.0",
                                          "element vertex 3",
                                          "element face 1",
                                          "property float x",
                                          "property list uchar int vertex_indices",
                                          "end_header",
                                          "OFF",
                                          "v 0 0 0",
                                          "f 1 2 3",
                                          "f -1 -2 -3",
                                          "3 0 1 2",
                                          "0 0 0",
                                          "1",
                                          "-1",
                                          "1e308",
                                          "nan",
                                          "#",
                                          "\\",
                                          "\r",
                                          "/",
                                          "\0x"};
  std::mt19937 random(99);
  int errors = 0;
  for (int round = 0; round < 2000; ++round) {
    const char* name = round % 2 == 0 ? "words.obj" : "words.off";
    std::string bytes;
    for (std::size_t count = random() % 30; count > 0; --count)
      bytes += words[random() % words.size()] + (random() % 4 == 0 ? " " : "\n");
    INFO("round " << round);
    if (read_hostile(directory.file(name, bytes)) == Outcome::kError) ++errors;
  }
  CHECK(errors > 1900);
}
