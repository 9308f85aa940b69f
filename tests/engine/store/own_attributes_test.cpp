// Attributes of a program: with all their levels by one call, of the program's own record types,
// and not to be changed in a store that was opened for reading.
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "engine/store/sample_store.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/verify.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

struct Material {
  double density, stiffness;
  friend bool operator==(const Material&, const Material&) = default;
};

}  // namespace

template <>
struct plait::RecordTraits<Material> : plait::RecordOf<double, 2> {};

namespace {

Store in_memory(int base_level = 0) {
  StoreOptions options = sample_options("memory");
  return Store::create({}, BaseMesh::build(octahedron()), options, default_backends(),
                       {.base_level = base_level});
}

}  // namespace

TEST_CASE("AddAttribute_WithLevels_HasThemAndTheyAreZero") {
  for (const int base_level : {0, 2}) {
    Store store = in_memory(base_level);
    const AttributeId id = store.add_attribute(schema_of<float>("age"), base_level + 3);
    CHECK(store.attributes()[id].finest_level == base_level + 3);
    for (int level = base_level + 1; level <= base_level + 3; ++level)
      CHECK(std::ranges::all_of(read_level(store, id, level),
                                [](std::byte byte) { return byte == std::byte{}; }));
    CHECK_NOTHROW(store.commit());
  }
}

TEST_CASE("AddAttribute_WithImpossibleLevels_IsRefusedAndAddsNothing") {
  Store store = in_memory(2);
  for (const int level : {-1, 1, kMaxLevel + 1}) {
    const Error error = error_of([&] { store.add_attribute(schema_of<float>("age"), level); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"'age'", "expected 2 to 20"}));
    CHECK(store.attributes().empty());
  }
  CHECK(store.add_attribute(schema_of<float>("age"), 2) == 0);
}

TEST_CASE("AddAttribute_LevelThatCannotBeMade_LeavesTheStoreAsBefore") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  Store store = Store::create(path, BaseMesh::build(octahedron()), sample_options("pread"),
                              default_backends());
  const AttributeId sample = add_sample(store, sample_schemas()[0], 2);
  store.commit();
  // A directory is in the place of the third level's file.
  std::filesystem::create_directories(path / "attribute1.level03.2" / "full");
  CHECK_THROWS_AS(store.add_attribute(schema_of<float>("age"), 4), Error);
  CHECK(store.attributes().size() == 1);
  CHECK_FALSE(store.has_attribute("age"));
  const AttributeId again = store.add_attribute(schema_of<float>("age"), 4);
  CHECK(store.attributes()[again].finest_level == 4);
  store.commit();
  store.close();
  Store reopened = Store::open(path, {}, default_backends());
  CHECK(reopened.attributes().size() == 2);
  CHECK(holds_sample(reopened, sample));
  CHECK(verify(reopened).damaged.empty());
}

TEST_CASE("RecordTraits_OfAProgramsStruct_StoresItAsItsComponents") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  const AttributeSchema schema = schema_of<Material>("material");
  CHECK(schema == AttributeSchema{"material", ComponentType::kFloat64, 2});
  CHECK(schema_of<std::array<std::uint8_t, 4>>("colour") ==
        AttributeSchema{"colour", ComponentType::kUint8, 4});
  CHECK(schema_of<std::int16_t>("x").type == ComponentType::kInt16);
  {
    Store store = Store::create(path, BaseMesh::build(octahedron()), sample_options("pread"),
                                default_backends());
    const AttributeId id = store.add_attribute(schema, 1);
    for (VertexId vertex = 0; vertex < 6; ++vertex)
      store.base_records<Material>(id)[vertex] = {double(vertex), 0.5};
    const std::vector<Material> made(12, Material{7, 8});
    write_level(store, id, 1, std::as_bytes(std::span(made)));
    store.commit();
  }
  const Store store = Store::open(path, {}, default_backends());
  const Reader reader(store);
  const PatchView patch = reader.read_patch(0, 1);
  const auto material = patch.attribute<Material>("material");
  CHECK(material.at(0, 0) == Material{double(store.base().faces()[0][0]), 0.5});
  CHECK(material.at(1, 1) == Material{7, 8});
  const Error error = error_of([&] { patch.attribute<float>("material"); });
  CHECK(names(error, {"float64 x 2", "float32 x 1"}));
}

TEST_CASE("BaseRecords_OfAStoreOpenedForReading_CanOnlyBeRead") {
  const TemporaryDirectory directory(Medium::kMemory);
  const std::filesystem::path path = directory.path() / "s.plait";
  {
    Store store = Store::create(path, BaseMesh::build(octahedron()), sample_options("pread"),
                                default_backends());
    add_sample(store, sample_schemas()[0], 1);
    store.commit();
  }
  Store store = Store::open(path, {}, default_backends());
  for (const Error& error : {error_of([&] { store.base_bytes(0); }),
                             error_of([&] { store.base_records<Vector3<float>>(0); })}) {
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {"s.plait", "opened for reading", "const Store"}));
  }
  CHECK(std::as_const(store).base_records<Vector3<float>>(0).size() == 6);
  CHECK(holds_sample(store, 0));
}
