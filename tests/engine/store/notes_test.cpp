// What a store has beside levels: texts, attributes of the base faces, and where everything was in
// the program's own mesh. Commits record them, copies have them, roll_back() brings them back.
#include "plait/notes.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "engine/store/sample_store.h"
#include "plait/extend/check_store.h"
#include "plait/extend/copy_levels.h"
#include "plait/layout.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

std::vector<std::uint16_t> some_numbers(const Store& store, std::uint16_t first) {
  std::vector<std::uint16_t> numbers(store.base().face_count());
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

void set_numbers(Store& store, const std::vector<std::uint16_t>& numbers) {
  std::ranges::copy(numbers, store.notes().face_records<std::uint16_t>("part").begin());
}

bool has_numbers(const Store& store, const std::vector<std::uint16_t>& numbers) {
  return std::ranges::equal(store.notes().face_records<std::uint16_t>("part"), numbers);
}

Store make(const std::filesystem::path& path, const std::string& backend) {
  IndexedMesh mesh = random_sheet(5, 60);
  std::swap(mesh.faces[2][0], mesh.faces[2][1]);
  Store store = Store::create(path, lay_out(BaseMesh::build(mesh), LayoutKind::kHilbert),
                              sample_options(backend), default_backends());
  store.notes().add_face_attribute({"part", ComponentType::kUint16, 1});
  set_numbers(store, some_numbers(store, 7));
  store.notes().set_text("unit", "mm");
  store.notes().set_text("author", "Zoë");
  add_sample(store, sample_schemas()[0], 2);
  store.commit();
  return store;
}

}  // namespace

TEST_CASE("Notes_OfACommit_AreThereAfterReopening") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    const auto path = directory.path() / "s.plait";
    const InputMaps maps = make(path, backend).base().input_maps();
    Store store = Store::open(path, {.writable = true}, default_backends());
    CHECK(store.notes().texts() == Texts{{"author", "Zoë"}, {"unit", "mm"}});
    REQUIRE(store.notes().face_attributes().size() == 1);
    CHECK(store.notes().face_attributes()[0] == AttributeSchema{"part", ComponentType::kUint16, 1});
    CHECK(has_numbers(store, some_numbers(store, 7)));
    CHECK(store.base().input_maps().input_faces == maps.input_faces);
    CHECK(store.base().input_maps().turned == maps.turned);
    CHECK(maps.turned != std::vector<bool>(maps.turned.size(), false));

    // Each change alone makes a version, and the next one has it.
    const std::uint64_t first = store.sequence();
    store.commit();
    CHECK(store.sequence() == first);
    set_numbers(store, some_numbers(store, 100));
    store.commit();
    CHECK(store.sequence() == first + 1);
    store.notes().set_text("unit", "");
    store.commit();
    CHECK(store.sequence() == first + 2);
    store.notes().remove_face_attribute("part");
    store.notes().add_face_attribute({"colour", ComponentType::kUint32, 1});
    store.close();
    store = Store::open(path, {.writable = true}, default_backends());
    CHECK(store.notes().texts() == Texts{{"author", "Zoë"}});
    CHECK(has_numbers(store, some_numbers(store, 100)));
    store.notes().remove_face_attribute("part");
    store.commit();
    store.close();
    store = Store::open(path, {}, default_backends());
    CHECK(store.notes().face_attributes().empty());
    CHECK(check_store(path, default_backends()).left_over.empty());
  }
}

TEST_CASE("Notes_FaceAttributesOfEveryType_KeepTheirNumbers") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  const auto name_of = [](ComponentType type) { return std::string(to_string(type)); };
  {
    Store store = make(path, "pread");
    for (int number = 1; number <= 10; ++number) {
      const auto type = static_cast<ComponentType>(number);
      store.notes().add_face_attribute({name_of(type), type, 1});
      const std::span<std::byte> bytes = store.notes().face_bytes(name_of(type));
      for (std::size_t at = 0; at < bytes.size(); ++at)
        bytes[at] = static_cast<std::byte>(at % 251);
    }
    store.notes().face_records<double>("float64")[1] = -0.25;
    store.commit();
  }
  const Store store = Store::open(path, {}, default_backends());
  CHECK(store.notes().face_attributes().size() == 11);
  for (int number = 1; number <= 10; ++number) {
    const auto type = static_cast<ComponentType>(number);
    const std::span<const std::byte> bytes = store.notes().face_bytes(name_of(type), type);
    REQUIRE(bytes.size() == store.base().face_count() * component_bytes(type));
    CHECK(bytes.back() == static_cast<std::byte>((bytes.size() - 1) % 251));
  }
  CHECK(store.notes().face_records<double>("float64")[1] == -0.25);
  CHECK(check_store(path, default_backends()).left_over.empty());
}

TEST_CASE("Notes_RolledBack_AreThoseOfTheCommit") {
  for (const char* backend : {"memory", "pread", "compressed"}) {
    CAPTURE(backend);
    const TemporaryDirectory directory;
    const bool on_disk = std::string(backend) != "memory";
    Store store = make(on_disk ? directory.path() / "s.plait" : std::filesystem::path(), backend);
    store.notes().set_text("unit", "inch");
    set_numbers(store, some_numbers(store, 1000));
    store.notes().add_face_attribute({"colour", ComponentType::kUint8, 1});
    store.roll_back();
    CHECK(store.notes().texts() == Texts{{"author", "Zoë"}, {"unit", "mm"}});
    CHECK(store.notes().face_attributes().size() == 1);
    CHECK(has_numbers(store, some_numbers(store, 7)));
    CHECK(holds_sample(store, 0));
  }
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  store.notes().set_text("unit", "mm");
  store.notes().add_face_attribute({"part", ComponentType::kUint8, 1});
  store.roll_back();
  CHECK(store.notes().texts().empty());
  CHECK(store.notes().face_attributes().empty());
}

TEST_CASE("Notes_OfACopy_AreThoseOfTheSource") {
  const TemporaryDirectory directory;
  Store from = make(directory.path() / "s.plait", "pread");
  Store to = Store::create(directory.path() / "t.plait", from.base(), sample_options("compressed"),
                           default_backends(), from.provenance());
  copy_levels(from, to);
  to.commit();
  to.close();
  to = Store::open(directory.path() / "t.plait", {}, default_backends());
  CHECK(to.notes().texts() == from.notes().texts());
  CHECK(has_numbers(to, some_numbers(to, 7)));
  CHECK(to.base().input_maps().input_faces == from.base().input_maps().input_faces);
}

TEST_CASE("Notes_WrongNamesTextsAndTypes_AreRefused") {
  Store store = make({}, "memory");
  const auto refused = [&](const auto& call) { return error_of(call).code(); };
  using E = ErrorCode;
  for (const std::string& name : {std::string(), std::string("a b"), std::string(256, 'n')}) {
    CHECK(refused([&] { store.notes().set_text(name, "x"); }) == E::kInvalidArgument);
    CHECK(refused([&] {
            store.notes().add_face_attribute({name, ComponentType::kUint8, 1});
          }) == E::kInvalidArgument);
  }
  for (const std::string& text :
       {std::string("\x80"), std::string("\xc0\x80"), std::string("\xed\xa0\x80"),
        std::string("\xf4\x90\x80\x80"), std::string("a\r"), std::string("\0a", 2),
        std::string("\xc2\x85"), std::string(65537, 'x')})
    CHECK(refused([&] { store.notes().set_text("note", text); }) == E::kInvalidArgument);
  store.notes().set_text("note", std::string(65536, 'x'));
  CHECK(store.notes().texts().size() == 3);
  CHECK(refused([&] {
          store.notes().add_face_attribute({"part", ComponentType::kUint8, 1});
        }) == E::kInvalidArgument);
  for (const AttributeSchema& schema : {AttributeSchema{"none", static_cast<ComponentType>(11), 1},
                                        {"two", ComponentType::kUint8, 2}})
    CHECK(refused([&] { store.notes().add_face_attribute(schema); }) == E::kInvalidArgument);
  CHECK(refused([&] { store.notes().face_records<std::uint8_t>("part"); }) == E::kInvalidArgument);
  CHECK(refused([&] { store.notes().face_bytes("colour"); }) == E::kNotFound);
  CHECK(refused([&] { store.notes().remove_face_attribute("colour"); }) == E::kNotFound);
  {
    const Reader reader(store);
    CHECK(refused([&] { store.notes().face_bytes("part"); }) == E::kBusy);
    CHECK(refused([&] { store.notes().set_text("unit", "m"); }) == E::kBusy);
  }
}

TEST_CASE("Notes_DamagedFaceAttribute_IsFound") {
  const TemporaryDirectory directory;
  const auto path = directory.path() / "s.plait";
  make(path, "pread");
  std::string damaged;
  for (const std::string& name : file_names(path))
    if (name.find(".faces.") != std::string::npos) damaged = name;
  REQUIRE(!damaged.empty());
  overwrite_byte(path / damaged, 5, std::byte{0xee});
  CHECK(error_of([&] { Store::open(path, {}, default_backends()); }).code() ==
        ErrorCode::kCorruption);
  const StoreCheck check = check_store(path, default_backends());
  REQUIRE(check.damaged.size() == 1);
  CHECK(check.damaged[0].kind == StoreFile::kFaceRecords);
  CHECK(check.damaged[0].attribute == "part");
}
