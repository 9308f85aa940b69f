// docs/format.md: a reader written from it finds in a store what the library was told to put there.
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "engine/store/format_reader.h"
#include "engine/store/sample_store.h"
#include "plait/extend/patch.h"
#include "plait/extend/store_access.h"
#include "plait/layout.h"
#include "plait/notes.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "store/attribute_levels.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

constexpr int kLevels = 4;

/// Integer positions, so that linear interpolation is exact and one vertex has one position,
/// whichever face it is seen from; three of a face do not repeat one.
IndexedMesh with_integer_positions(IndexedMesh mesh) {
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto x = static_cast<double>(v);
    mesh.positions[v] = {x, x * x, x * x * x};
  }
  return mesh;
}

Vector3<double> interpolated(const Vector3<double>& a, const Vector3<double>& b,
                             const Vector3<double>& c, double wa, double wb, double wc) {
  return wa * a + wb * b + wc * c;
}

/// Writes every vertex of every face through at(level, i, j).
void write_positions(Store& store, AttributeId id) {
  std::ranges::copy(store.base().positions(), store.base_records<Vector3<double>>(id).begin());
  for (int level = 1; level <= kLevels; ++level) store.add_level(id);
  StorePatches<Vector3<double>> patches(store, id, 1 << 16);
  const int finest = store.base_level() + kLevels;
  patches.activate(finest, store.base_level() + 1, finest);
  constexpr std::int64_t kSize = 1 << kLevels;
  for (FaceId face = 0; face < store.base().face_count(); ++face) {
    const auto patch = patches.patch(face);
    const auto& corners = store.base().faces()[face];
    const auto at = [&](std::size_t corner) { return store.base().positions()[corners[corner]]; };
    for (std::int64_t j = 0; j <= kSize; ++j)
      for (std::int64_t i = 0; i + j <= kSize; ++i) {
        const auto weight = [](std::int64_t k) { return static_cast<double>(k) / kSize; };
        patch.at(finest, i, j) =
            interpolated(at(0), at(1), at(2), weight(kSize - i - j), weight(i), weight(j));
      }
  }
}

void check_positions(const format::Store& store, const format::Attribute& attribute) {
  REQUIRE(attribute.finest_level - store.base_level == kLevels);
  for (const auto& [level, bytes] : attribute.levels) {
    const std::uint32_t k = level - store.base_level;
    const std::int64_t n = std::int64_t{1} << (k - 1);
    std::size_t offset = 0;
    bool right = true;
    for (const format::Edge& edge : store.edges)
      for (std::int64_t row = 0; row < n; ++row)
        for (std::int64_t column = 0; column < (edge.is_border() ? n - row : n); ++column) {
          const format::Place place = place_of(store, edge, k, row, column);
          for (std::size_t axis = 0; axis < 3; ++axis, offset += 8) {
            double expected = 0, found = 0;
            for (std::size_t corner = 0; corner < 3; ++corner)
              expected += static_cast<double>(place.weights[corner]) / static_cast<double>(2 * n) *
                          store.positions[place.vertices[corner]][axis];
            std::memcpy(&found, &bytes.at(offset), 8);
            right &= found == expected;
          }
        }
    INFO("level " << level);
    CHECK(right);
    CHECK(offset == bytes.size());
  }
}

bool equal(const format::Bytes& found, const std::vector<std::byte>& expected) {
  return found.size() == expected.size() &&
         std::memcmp(found.data(), expected.data(), found.size()) == 0;
}

struct Variant {
  std::string backend, pipeline;
  int base_level = 0;
};

void check_store(const IndexedMesh& mesh, const Variant& variant) {
  INFO(variant.backend << " " << variant.pipeline);
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  StoreUuid uuid;
  std::vector<std::byte> noise_base, noise_levels[2], part;
  {
    StoreOptions options = sample_options(variant.backend);
    options.base_index = true;
    options.pipeline = variant.pipeline;
    Store store = Store::create(path, BaseMesh::build(with_integer_positions(mesh)), options,
                                default_backends(), {.base_level = variant.base_level});
    uuid = store.info().uuid;
    StoreAccess::set_provenance(
        store, {"midpoint", true, ComponentType::kFloat64, "given", variant.base_level, "0.12.3"});
    const AttributeId dropped = add_sample(store, {"dropped", ComponentType::kUint8, 1}, 1);
    const AttributeId noise = add_sample(store, sample_schemas()[5], 2);
    store.replace_attribute(dropped, noise);  // numbers and positions now differ
    store.commit();
    const AttributeId id = store.add_attribute({"position", ComponentType::kFloat64, 3});
    write_positions(store, id);
    noise_base.assign(store.base_bytes(0).begin(), store.base_bytes(0).end());
    for (int level : {1, 2})
      noise_levels[level - 1] = read_level(store, 0, variant.base_level + level);
    const AttributeId some = add_sample(store, {"part", ComponentType::kUint16, 255}, 0);
    store.add_level(some);
    LevelFile& file = StoreAccess::level_file(store, some, variant.base_level + 1);
    REQUIRE(file.geometry.block_count() > 1);
    std::ranges::fill(StoreAccess::open_session(store).pin(file, 1, Access::kOverwrite).bytes(),
                      std::byte{7});
    part = read_level(store, some, variant.base_level + 1);
    store.commit();
    if (variant.base_level > 0) commit_anew(store);  // both slots of the manifest get their turn
  }
  const format::Store store = format::read_store(path);
  CHECK(std::memcmp(store.uuid.data(), uuid.data(), 16) == 0);
  CHECK(store.sequence == (variant.base_level > 0 ? 3 : 2));
  CHECK(store.block_bytes == 4096);
  CHECK(store.base_level == static_cast<std::uint32_t>(variant.base_level));
  CHECK(store.next_attribute_number == 4);
  CHECK(store.backend == variant.backend);
  CHECK(store.pipeline == variant.pipeline);
  CHECK(store.layout == "given");
  CHECK(store.scheme == "midpoint");
  CHECK(store.limit);
  CHECK(store.precision == 2);
  CHECK(store.program == "0.12.3");
  REQUIRE(store.attributes.size() == 3);
  const format::Attribute& noise = store.attributes[0];
  CHECK(noise.name == "dropped");
  CHECK(noise.number == 1);
  CHECK(noise.type == 7);
  CHECK(noise.components == 5);
  CHECK(equal(noise.base, noise_base));
  for (int level : {1, 2})
    CHECK(equal(noise.levels.at(static_cast<std::uint32_t>(variant.base_level + level)),
                noise_levels[level - 1]));
  CHECK(store.attributes[1].name == "position");
  CHECK(store.attributes[1].number == 2);
  check_positions(store, store.attributes[1]);
  CHECK(equal(store.attributes[2].levels.begin()->second, part));
  CHECK(store.blocks_of_encoding[0] > 0);
  CHECK(store.blocks_of_encoding[1] > 0);
  CHECK((store.blocks_of_encoding[2] > 0) == (variant.pipeline.find("lz4") != std::string::npos ||
                                              variant.pipeline.find("zstd") != std::string::npos));
}

}  // namespace

TEST_CASE("BlockChecksum_ExampleOfTheDocument_IsThatNumber") {
  StoreUuid uuid;
  for (std::size_t i = 0; i < uuid.size(); ++i) uuid[i] = static_cast<std::byte>(i);
  BlockTable table(uuid, 1, 2, 4);
  const std::string stored = "plait";
  table.seal(3, 0, BlockEncoding::kRaw, std::as_bytes(std::span(stored)));
  CHECK(table[3].checksum == 0x6f8af1c89f8c60ddu);
}

TEST_CASE("Format_ReadAsTheDocumentSays_HoldsWhatWasWritten") {
  for (const IndexedMesh& mesh : {random_sphere(3, 60), random_sheet(5, 60), two_components()}) {
    check_store(mesh, {"pread", "none"});
    check_store(mesh, {"mmap", "none", 2});
    for (const char* pipeline : {"zstd", "zstd:-5", "lz4", "none", "shuffle,none", "shuffle,zstd",
                                 "shuffle,zstd:-5", "shuffle,lz4"})
      check_store(mesh, {"compressed", pipeline});
  }
}

TEST_CASE("Format_PipelinesOfAttributesAndLevelsAndLongStrings_AreReadAsTheDocumentSays") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  const std::string scheme(5000, 's'), layout(65536, 'l');
  const AttributeSchema smooth{"smooth" + std::string(200, '-'), ComponentType::kFloat32, 3};
  std::vector<std::byte> expected[4];
  {
    StoreOptions options = sample_options("compressed");
    options.pipeline = "zstd:3";
    Store store = Store::create(path, BaseMesh::build(random_sphere(3, 60)), options,
                                default_backends(), {.layout = layout});
    Provenance provenance = store.provenance();
    provenance.scheme = scheme;
    StoreAccess::set_provenance(store, provenance);
    const AttributeId id = add_sample(store, smooth, 1);
    store.commit();
    store.set_pipeline(id, "shuffle,lz4;@4=zstd:1");
    for (const int level : {2, 3, 4}) {
      store.add_level(id);
      write_level(store, id, level, sample_level(store, smooth, level));
    }
    store.commit();
    for (const int level : {1, 2, 3, 4}) expected[level - 1] = sample_level(store, smooth, level);
  }
  const format::Store read = format::read_store(path);
  CHECK(read.scheme == scheme);
  CHECK(read.layout == layout);
  REQUIRE(read.attributes.size() == 1);
  const format::Attribute& attribute = read.attributes[0];
  CHECK(attribute.name == smooth.name);
  CHECK(attribute.pipeline == "shuffle,lz4;@4=zstd:1");
  REQUIRE(attribute.described.size() == 4);
  CHECK(attribute.described[3].pipeline == "zstd:1");
  CHECK(attribute.described[0].pipeline == "zstd:3");
  CHECK(attribute.described[0].generation == 1);
  for (const std::size_t level : {1u, 2u}) {
    CHECK(attribute.described[level].pipeline == "shuffle,lz4");
    CHECK(attribute.described[level].generation == 2);
  }
  for (const std::uint32_t level : {1u, 2u, 3u, 4u})
    CHECK(equal(attribute.levels.at(level), expected[level - 1]));
  Store store = Store::open(path, {}, default_backends());
  CHECK(store.provenance().scheme == scheme);
  CHECK(store.provenance().layout == layout);
  CHECK(StoreAccess::level_file(store, 0, 1).pipeline == "zstd:3");
  CHECK(StoreAccess::level_file(store, 0, 3).pipeline == "shuffle,lz4");
  CHECK(pipelines_of_levels(store, 0) == "zstd:1;@1=zstd:3;@2-3=shuffle,lz4");
  CHECK(holds_sample(store, 0));
}

TEST_CASE("Format_TextsFaceAttributesAndMapsToTheInput_AreReadAsTheDocumentSays") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "s.plait";
  IndexedMesh input = random_sphere(3, 60);
  input.positions.insert(input.positions.begin() + 4, {9, 9, 9});  // no face uses it
  for (auto& face : input.faces)
    for (VertexId& vertex : face) vertex += vertex >= 4 ? 1 : 0;
  input.positions.push_back({8, 8, 8});
  for (const std::size_t face : {std::size_t{3}, std::size_t{7}})
    std::swap(input.faces[face][1], input.faces[face][2]);
  const std::string note = "\tGitter für Ü-Wagen\n\xe2\x82\xac 20";
  {
    StoreOptions options = sample_options("pread");
    options.base_index = true;
    Store store = Store::create(path, lay_out(BaseMesh::build(input), LayoutKind::kHilbert),
                                options, default_backends());
    store.notes().set_text("unit", "mm");
    store.notes().set_text("author", note);
    store.notes().add_face_attribute({"material", ComponentType::kUint16, 1});
    store.notes().add_face_attribute({"part", ComponentType::kUint32, 1});
    const std::span<std::uint32_t> part = store.notes().face_records<std::uint32_t>("part");
    for (std::size_t face = 0; face < part.size(); ++face)
      part[face] = static_cast<std::uint32_t>(70000 * face);
    store.commit();
  }
  const format::Store read = format::read_store(path);
  CHECK(read.texts == std::map<std::string, std::string>{{"author", note}, {"unit", "mm"}});
  REQUIRE(read.face_attributes.size() == 2);
  CHECK(read.face_attributes[0].name == "material");
  CHECK(read.face_attributes[0].numbers == format::Bytes(2 * input.faces.size(), 0));
  CHECK(read.face_attributes[1].name == "part");
  CHECK(read.face_attributes[1].type == 9);
  for (std::uint32_t face = 0; face < input.faces.size(); ++face) {
    std::uint32_t number = 0;
    std::memcpy(&number, &read.face_attributes[1].numbers.at(4 * face), 4);
    REQUIRE(number == 70000 * face);
  }
  CHECK(read.input_vertex_count == input.positions.size());
  REQUIRE(read.input_vertices.size() == read.positions.size());
  for (std::size_t vertex = 0; vertex < read.positions.size(); ++vertex) {
    const Vector3<double>& there = input.positions.at(read.input_vertices[vertex]);
    REQUIRE(read.positions[vertex] == std::array<double, 3>{there.x, there.y, there.z});
  }
  int turned = 0;
  for (std::size_t face = 0; face < read.faces.size(); ++face) {
    auto corners = input.faces.at(read.input_faces[face] / 2);
    if (read.input_faces[face] % 2 != 0) {
      std::swap(corners[1], corners[2]);
      ++turned;
    }
    for (std::size_t corner = 0; corner < 3; ++corner)
      REQUIRE(read.input_vertices[read.faces[face][corner]] == corners[corner]);
  }
  CHECK(turned == 2);
}
