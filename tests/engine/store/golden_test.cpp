// The stores of tests/golden, which an earlier build has written: the library and the reader that
// was written from docs/format.md find in them what subdividing the mesh gives today.
#include <catch2/catch.hpp>
#include <cstring>
#include <utility>

#include "engine/store/format_reader.h"
#include "engine/store/sample_store.h"
#include "plait/digest.h"
#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/notes.h"
#include "plait/registry.h"
#include "plait/subdivide.h"
#include "support/temporary_directory.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kGoldenLevels = 3;
constexpr char kDigest[] = "fa42a859db257a51cda584997262fc4b";
constexpr char kNotesDigest[] = "9e5fa33a5b19441eebde77af184cd3f5";

Digest digest_of_today(const std::filesystem::path& golden) {
  Store store = Store::create({}, read_base_mesh(golden / "open_octahedron.off"),
                              {.backend = "memory"}, default_backends());
  add_base_positions(store);
  subdivide(store, {.executor = ExecutorKind::kSweep, .levels = kGoldenLevels, .normals = true});
  return digest(store);
}

}  // namespace

TEST_CASE("GoldenStore_OfFormat2_HoldsWhatSubdividingItsMeshGives") {
  const std::filesystem::path golden = PLAIT_GOLDEN_DIRECTORY;
  REQUIRE(digest_of_today(golden).to_string() == kDigest);
  for (const char* name : {"raw.plait", "encoded.plait"}) {
    INFO(name);
    const TemporaryDirectory directory(Medium::kMemory);
    const std::filesystem::path path = directory.path() / name;
    std::filesystem::copy(golden / name, path);
    Store store = Store::open(path, {}, default_backends());
    CHECK(digest(store).to_string() == kDigest);
    CHECK(store.provenance().scheme == "loop");
    CHECK(store.provenance().layout == "hilbert");

    const format::Store read = format::read_store(path);
    REQUIRE(read.attributes.size() == store.attributes().size());
    for (AttributeId id = 0; id < store.attributes().size(); ++id) {
      CHECK(read.attributes[id].name == store.attributes()[id].schema.name);
      REQUIRE(read.attributes[id].levels.size() == kGoldenLevels);
      for (const auto& [level, bytes] : read.attributes[id].levels) {
        const std::vector<std::byte> expected = read_level(store, id, static_cast<int>(level));
        REQUIRE(bytes.size() == expected.size());
        CHECK(std::memcmp(bytes.data(), expected.data(), bytes.size()) == 0);
      }
    }
  }
}

TEST_CASE("GoldenStore_WithNotes_HasWhatItsProgramPutThere") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "notes.plait";
  std::filesystem::copy(std::filesystem::path(PLAIT_GOLDEN_DIRECTORY) / "notes.plait", path);
  Store store = Store::open(path, {}, default_backends());
  CHECK(store.notes().texts() == Texts{{"author", "Zoë"}, {"unit", "mm"}});
  const InputMaps maps = store.base().input_maps();
  CHECK(maps.input_vertex_count == 8);
  CHECK(maps.vertices[0] == kNoId);
  CHECK(maps.vertices[4] == kNoId);
  const auto material = std::as_const(store).notes().face_records<std::uint16_t>("material");
  REQUIRE(material.size() == 4);
  for (FaceId face = 0; face < 4; ++face) {
    CHECK(material[face] == 300 * (face + 1));
    CHECK(maps.turned[face] == (maps.input_faces[face] == 1));
  }
  CHECK(digest(store).to_string() == kNotesDigest);

  const format::Store read = format::read_store(path);
  CHECK(read.texts.at("unit") == "mm");
  CHECK(read.face_attributes.at(0).name == "material");
  CHECK(read.input_vertex_count == 8);
  for (FaceId face = 0; face < 4; ++face)
    CHECK(read.input_faces[face] == 2 * maps.input_faces[face] + (maps.turned[face] ? 1 : 0));
}
