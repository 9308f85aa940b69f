// A store's life: create, fill, commit, open, change, commit again.
#include "plait/store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>
#include <map>
#include <utility>

#include "engine/store/sample_store.h"
#include "format/manifest.h"
#include "maintenance/repair_files.h"
#include "plait/extend/check_store.h"
#include "plait/extend/file.h"
#include "plait/extend/store_access.h"
#include "plait/registry.h"
#include "plait/store_info.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

using namespace plait;
using namespace plait::test;

namespace {

using Names = std::set<std::string>;

/// A directory with room for one store.
struct Place {
  TemporaryDirectory directory;
  std::filesystem::path path = directory.path() / "s.plait";

  Store create(const std::string& backend, const IndexedMesh& mesh = random_sheet(5, 40)) const {
    return Store::create(path, BaseMesh::build(mesh), sample_options(backend), default_backends());
  }
  Store open(bool writable = false) const {
    return Store::open(path, {.writable = writable, .budget_bytes = 1 << 20, .io_threads = 0},
                       default_backends());
  }
  /// A committed store with attribute "position" of one level.
  void make(const std::string& backend = "pread") const {
    Store store = create(backend);
    add_sample(store, sample_schemas()[0], 1);
    store.commit();
  }
};

/// A process that runs `body` once run() says so, and ends with its result. The test makes it
/// before anything that starts a thread: a child inherits the locks that threads of its parent
/// hold, those of a sanitizer's allocator among them, and nobody opens these again.
class ChildProcess {
 public:
  explicit ChildProcess(const std::function<int()>& body) {
    REQUIRE(::pipe2(pipe_, O_CLOEXEC) == 0);
    child_ = ::fork();
    REQUIRE(child_ >= 0);
    if (child_ != 0) return;
    ::close(pipe_[1]);
    char start = 0;
    int status = 99;
    try {
      if (::read(pipe_[0], &start, 1) == 1) status = body();
    } catch (...) {
    }
    ::_exit(status);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess() {
    ::close(pipe_[0]);
    ::close(pipe_[1]);
    if (child_ > 0) ::waitpid(child_, nullptr, 0);
  }

  /// The exit status; -1 if the process was killed.
  int run() {
    REQUIRE(::write(pipe_[1], "", 1) == 1);
    int status = 0;
    REQUIRE(::waitpid(std::exchange(child_, 0), &status, 0) > 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  int pipe_[2] = {-1, -1};
  pid_t child_ = 0;
};

}  // namespace

TEST_CASE("StoreCreate_WhereAWriterWasKilledBeforeItsFirstCommit_ReplacesIt") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  const auto make_left_over = [&](bool begun, const char* further) {
    std::filesystem::create_directory(path);
    const Directory directory(path);
    if (begun) create_begun_manifest(directory, false);
    for (const char* name : {"lock", "base.mesh", "attribute0.base.1", "version.1"})
      File(directory, name, OpenMode::kCreate);
    if (further) File(directory, further, OpenMode::kCreate);
  };
  const auto create = [&] {
    return Store::create(path, BaseMesh::build(two_triangles()), sample_options("pread"),
                         default_backends());
  };
  make_left_over(true, nullptr);
  create().commit();
  CHECK(file_names(path) == Names{"base.mesh", "lock", "manifest", "version.1"});
  std::filesystem::remove_all(path);
  // One that lost its manifest, and one that is somebody else's.
  for (const auto& [begun, further] :
       std::map<bool, const char*>{{false, "version.3"}, {true, "notes.txt"}}) {
    make_left_over(begun, further);
    const Names before = file_names(path);
    CHECK(error_of([&] { create(); }).code() == ErrorCode::kInvalidArgument);
    CHECK(file_names(path) == before);
    std::filesystem::remove_all(path);
  }
  // One that is being made.
  Store writer = create();
  CHECK(error_of([&] { create(); }).code() == ErrorCode::kInvalidArgument);
  writer.commit();
}

TEST_CASE("Store_CommittedAndOpened_HoldsTheSameBytesOnEveryBackend") {
  for (const std::string& backend : durable_backends())
    for (const IndexedMesh& mesh : {random_sphere(3, 60), random_sheet(5, 60), two_components()}) {
      INFO(backend);
      const Place place;
      const BaseMesh base = BaseMesh::build(mesh);
      StoreUuid uuid;
      {
        Store store = place.create(backend, mesh);
        uuid = store.info().uuid;
        CHECK(store.sequence() == 0);
        for (const AttributeSchema& schema : sample_schemas())
          add_sample(store, schema, schema.name == "wide" ? 2 : 3);
        store.commit();
        CHECK(store.sequence() == 1);
        for (AttributeId id = 0; id < 6; ++id) CHECK(holds_sample(store, id));
      }
      Store store = place.open();
      CHECK(store.info().uuid == uuid);
      CHECK(store.sequence() == 1);
      CHECK(store.path() == place.path);
      CHECK(store.options().backend == backend);
      CHECK(store.options().block_bytes == 4096);
      CHECK(store.base_level() == 0);
      CHECK(store.finest_level() == 3);
      CHECK(std::ranges::equal(store.base().positions(), base.positions()));
      CHECK(std::ranges::equal(store.base().faces(), base.faces()));
      CHECK(std::ranges::equal(store.base().face_edges(), base.face_edges()));
      REQUIRE(store.attributes().size() == 6);
      for (AttributeId id = 0; id < 6; ++id) {
        CHECK(store.attributes()[id].schema == sample_schemas()[id]);
        CHECK(store.attributes()[id].finest_level == (id == 4 ? 2 : 3));
        CHECK(store.attribute(sample_schemas()[id].name) == id);
        CHECK(holds_sample(store, id));
      }
      CHECK(store.info().paging.peak_frame_bytes <= 1 << 20);
    }
}

TEST_CASE("Store_InMemory_KeepsTheSameBytesAndTouchesNoDisk") {
  Store store = Store::create({}, BaseMesh::build(random_sheet(5, 60)), sample_options("memory"),
                              default_backends());
  for (const AttributeSchema& schema : sample_schemas()) add_sample(store, schema, 2);
  store.commit();
  CHECK(store.sequence() == 1);
  for (AttributeId id = 0; id < 6; ++id) CHECK(holds_sample(store, id));
}

TEST_CASE("StoreCreate_BackendAndPathThatDoNotGoTogether_IsRefused") {
  for (const std::string& backend : durable_backends()) {
    const Error error = error_of([&] {
      Store::create({}, BaseMesh::build(tetrahedron()), sample_options(backend),
                    default_backends());
    });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {backend, "needs a path"}));
  }
}

TEST_CASE("Store_BaseLevelAboveZero_CountsLevelsFromTheUsersMesh") {
  for (const std::string& backend : durable_backends()) {
    const Place place;
    {
      StoreOptions options = sample_options(backend);
      Store store = Store::create(place.path, BaseMesh::build(random_sheet(7, 30)), options,
                                  default_backends(), {.base_level = 2});
      CHECK(store.finest_level() == 2);
      const AttributeId id = add_sample(store, sample_schemas()[0], 2);
      CHECK(store.attributes()[id].finest_level == 4);
      store.commit();
    }
    CHECK(file_names(place.path).contains("attribute0.level03.1"));
    CHECK(file_names(place.path).contains("attribute0.level04.1"));
    Store store = place.open();
    CHECK(store.base_level() == 2);
    CHECK(store.finest_level() == 4);
    CHECK(StoreAccess::level_file(store, 0, 3).geometry.level() == BaseRelativeLevel(1));
    CHECK(holds_sample(store, 0));
  }
}

TEST_CASE("StoreOpen_NoStoreThere_IsNotFound") {
  const TemporaryDirectory directory;
  const auto code = [](const std::filesystem::path& path) {
    const Error error = error_of([&] { Store::open(path, {}, default_backends()); });
    CHECK(names(error, {path.string()}));
    return error.code();
  };
  CHECK(code(directory.path() / "nothing") == ErrorCode::kNotFound);
  CHECK(code(directory.path()) == ErrorCode::kNotFound);
  File(directory.path() / "lock", OpenMode::kCreate);
  CHECK(code(directory.path()) == ErrorCode::kNotFound);
  File(directory.path() / "file", OpenMode::kCreate);
  CHECK(code(directory.path() / "file") == ErrorCode::kNotFound);
  CHECK(std::filesystem::exists(directory.path() / "lock"));
}

TEST_CASE("Store_NeverCommitted_LeavesNothing") {
  for (const std::string& backend : durable_backends()) {
    const Place place;
    {
      Store store = place.create(backend);
      add_sample(store, sample_schemas()[0], 2);
      CHECK(std::filesystem::exists(place.path / "base.mesh"));
    }
    CHECK(file_names(place.directory.path()).empty());
  }
}

TEST_CASE("StoreCreate_PathThatExists_IsRefusedAndLeftAlone") {
  const Place place;
  place.make();
  const Names before = file_names(place.path);
  const Error error = error_of([&] { place.create("pread"); });
  CHECK(error.code() == ErrorCode::kInvalidArgument);
  CHECK(names(error, {place.path.string(), "exists"}));
  CHECK(file_names(place.path) == before);
  std::filesystem::remove_all(place.path);
  File(place.path, OpenMode::kCreate);
  CHECK_THROWS_AS(place.create("pread"), Error);
  CHECK(std::filesystem::is_regular_file(place.path));
}

TEST_CASE("StoreCreate_OptionsOutOfRange_AreRefusedBeforeAnythingIsMade") {
  const auto refused = [](const std::function<void(StoreOptions&)>& change, const char* word,
                          ErrorCode code = ErrorCode::kInvalidArgument) {
    const Place place;
    StoreOptions options = sample_options("compressed");
    change(options);
    const Error error = error_of([&] {
      Store::create(place.path, BaseMesh::build(tetrahedron()), options, default_backends());
    });
    CHECK(error.code() == code);
    CHECK(names(error, {word}));
    CHECK(file_names(place.directory.path()).empty());
  };
  for (const std::uint64_t bytes : {1u, 2048u, 5000u, 1u << 31})
    refused([&](StoreOptions& o) { o.block_bytes = bytes; }, "block size");
  const auto facts_refused = [](const Provenance& facts, const char* word) {
    const Place place;
    const Error error = error_of([&] {
      Store::create(place.path, BaseMesh::build(tetrahedron()), sample_options("compressed"),
                    default_backends(), facts);
    });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {word}));
    CHECK(file_names(place.directory.path()).empty());
  };
  facts_refused({.base_level = -1}, "base level");
  facts_refused({.base_level = 21}, "base level");
  refused([](StoreOptions& o) { o.budget_bytes = 65535; }, "budget");
  refused([](StoreOptions& o) { o.backend = "tape"; }, "pread", ErrorCode::kNotSupported);
  refused([](StoreOptions& o) { o.backend = "compressed:speed=9"; }, "speed=9",
          ErrorCode::kNotSupported);
  refused([](StoreOptions& o) { o.pipeline = "rar"; }, "zstd", ErrorCode::kNotSupported);
  refused([](StoreOptions& o) { o.pipeline = "blur,lz4"; }, "shuffle", ErrorCode::kNotSupported);
  refused(
      [](StoreOptions& o) {
        o.backend = "pread";
        o.pipeline = "lz4";
      },
      "expected pipeline");
  // What a version cannot hold is better refused now than at the first commit.
  facts_refused({.layout = std::string(65537, 'x')}, "65537 bytes");
}

TEST_CASE("StoreProvenance_WhatTheStoreIsNot_IsRefusedAndLeavesTheFormerOne") {
  StoreOptions options = sample_options("memory");
  Store store = Store::create({}, BaseMesh::build(octahedron()), options, default_backends(),
                              {.layout = "hilbert"});
  Provenance right = store.provenance();
  CHECK(right == Provenance{.layout = "hilbert"});
  right.scheme = "loop";
  right.limit = true;
  right.program = program_version();
  Provenance of_another_mesh = right;
  of_another_mesh.layout = "given";
  of_another_mesh.base_level = 1;
  StoreAccess::set_provenance(store, of_another_mesh);
  CHECK(store.provenance() == right);
  const auto refused = [&](Provenance wrong, const char* word) {
    const Error error = error_of([&] { StoreAccess::set_provenance(store, wrong); });
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {word}));
    CHECK(store.provenance() == right);
  };
  Provenance wrong = right;
  wrong.scheme = std::string(65537, 'x');
  refused(wrong, "65537 bytes");
  wrong.scheme = "two\nlines";
  refused(wrong, "not all of them printable");
}

TEST_CASE("StoreCommit_SecondAndThird_CountOnAndRemoveWhatNoSlotNames") {
  const Place place;
  place.make();
  const Names first = {"attribute0.base.1", "attribute0.level01.1", "base.mesh", "lock", "manifest",
                       "version.1"};
  CHECK(file_names(place.path) == first);
  {
    Store store = place.open(true);
    add_sample(store, sample_schemas()[1], 0);
    store.commit();
    CHECK(store.sequence() == 2);
    CHECK(file_names(place.path) == Names{"attribute0.base.1", "attribute0.base.2",
                                          "attribute0.level01.1", "attribute1.base.2", "base.mesh",
                                          "lock", "manifest", "version.1", "version.2"});
    commit_anew(store);
    CHECK(store.sequence() == 3);
  }
  CHECK(file_names(place.path) ==
        Names{"attribute0.base.2", "attribute0.base.3", "attribute0.level01.1", "attribute1.base.2",
              "attribute1.base.3", "base.mesh", "lock", "manifest", "version.2", "version.3"});
  Store store = place.open();
  CHECK(store.sequence() == 3);
  CHECK(holds_sample(store, 0));
  CHECK(holds_sample(store, 1));
}

TEST_CASE("Store_ClosedWithoutASecondCommit_IsAtTheFirst") {
  for (const std::string& backend : durable_backends()) {
    const Place place;
    place.make(backend);
    {
      Store store = place.open(true);
      store.add_level(0);
      write_level(store, 0, 2, sample_level(store, sample_schemas()[0], 2));
      store.base_bytes(0)[0] ^= std::byte{1};
      add_sample(store, sample_schemas()[1], 1);
    }
    {
      Store store = place.open();
      CHECK(store.sequence() == 1);
      CHECK(store.attributes().size() == 1);
      CHECK(store.finest_level() == 1);
      CHECK(holds_sample(store, 0));
    }
    // What that run left behind is in nobody's way.
    Store store = place.open(true);
    store.add_level(0);
    const std::vector<std::byte> zeros(StoreAccess::level_file(store, 0, 2).geometry.total_bytes());
    CHECK(read_level(store, 0, 2) == zeros);
    add_sample(store, sample_schemas()[2], 1);
    store.commit();
    CHECK(holds_sample(store, 1));
  }
}

TEST_CASE("StoreAddLevel_NeverWritten_ReadsAsZerosBeforeAndAfterACommit") {
  for (const std::string& backend : durable_backends()) {
    const Place place;
    {
      Store store = place.create(backend);
      const AttributeId id = store.add_attribute(sample_schemas()[0]);
      store.add_level(id);
      store.commit();
    }
    Store store = place.open();
    const std::vector<std::byte> zeros(StoreAccess::level_file(store, 0, 1).geometry.total_bytes());
    CHECK(read_level(store, 0, 1) == zeros);
    CHECK(std::ranges::all_of(std::as_const(store).base_bytes(0),
                              [](std::byte b) { return b == std::byte{}; }));
  }
}

TEST_CASE("StoreReplaceAttribute_Committed_LeavesOnlyTheReplacementsFiles") {
  for (const std::string& backend : durable_backends()) {
    const Place place;
    place.make(backend);
    {
      Store store = place.open(true);
      commit_anew(store);  // two versions have files now
      AttributeSchema schema = sample_schemas()[1];
      add_sample(store, schema, 2);
      store.replace_attribute(store.attribute("position"), store.attribute("mass"));
      CHECK(store.attributes().size() == 1);
      CHECK(store.attributes()[0].schema.name == "position");
      CHECK_FALSE(store.has_attribute("mass"));
      store.commit();
      CHECK(file_names(place.path) == Names{"attribute0.base.2", "attribute1.base.3",
                                            "attribute1.level01.3", "attribute1.level02.3",
                                            "base.mesh", "lock", "manifest", "version.2",
                                            "version.3"});
    }
    Store store = place.open();
    REQUIRE(store.attributes().size() == 1);
    CHECK(store.attributes()[0].schema == AttributeSchema{"position", ComponentType::kFloat64, 1});
    CHECK(store.finest_level() == 2);
    for (int level = 1; level <= 2; ++level)
      CHECK(read_level(store, 0, level) == sample_level(store, sample_schemas()[1], level));
  }
}

TEST_CASE("StoreReplaceAttribute_NotCommitted_IsUndoneByOpening") {
  const Place place;
  place.make();
  {
    Store store = place.open(true);
    add_sample(store, sample_schemas()[1], 1);
    store.replace_attribute(0, 1);
  }
  Store store = place.open();
  CHECK(store.attributes()[0].schema == sample_schemas()[0]);
  CHECK(holds_sample(store, 0));
}

TEST_CASE("StoreReplaceAttribute_ByAnEarlierOne_KeepsTheOthersInOrder") {
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  for (std::size_t i = 0; i < 4; ++i) add_sample(store, sample_schemas()[i], 1);
  const std::vector<std::byte> mass = read_level(store, 1, 1);
  store.replace_attribute(3, 1);
  REQUIRE(store.attributes().size() == 3);
  CHECK(store.attribute("position") == 0);
  CHECK(store.attribute("flag") == 1);
  CHECK(store.attribute("id") == 2);
  CHECK(read_level(store, 2, 1) == mass);
  CHECK(holds_sample(store, 1));
}

TEST_CASE("StoreReplaceAttribute_ByItself_IsRefused") {
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  add_sample(store, sample_schemas()[0], 1);
  CHECK(error_of([&] { store.replace_attribute(0, 0); }).code() == ErrorCode::kInvalidArgument);
  CHECK(holds_sample(store, 0));
}

TEST_CASE("StoreLock_Writer_ExcludesWritersAndReadersNamingItsProcess") {
  for (const bool writable : {false, true}) {
    CAPTURE(writable);
    const Place place;
    const std::string process = fmt::format("process {}", ::getpid());
    ChildProcess other([&] {
      try {
        place.open(writable);
      } catch (const Error& refusal) {
        return refusal.code() == ErrorCode::kBusy &&
                       std::strstr(refusal.what(), process.c_str()) != nullptr
                   ? 7
                   : 8;
      }
      return 9;
    });
    const Store writer = place.create("pread");
    const Error error = error_of([&] { place.open(writable); });
    CHECK(error.code() == ErrorCode::kBusy);
    CHECK(names(error, {"this process", place.path.string()}));
    CHECK(other.run() == 7);
  }
}

TEST_CASE("StoreLock_ReadersAndAWriter_DoNotKeepEachOtherOut") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const Place place;
    place.make(backend);
    ChildProcess reader([&] { return place.open().sequence() == 1 ? 7 : 8; });
    const Store first = place.open(), second = place.open();
    CHECK(reader.run() == 7);
    Store writer = place.open(true);
    CHECK(place.open().sequence() == 1);
    commit_anew(writer);
    CHECK(place.open().sequence() == 2);
    CHECK(first.sequence() == 1);
  }
}

TEST_CASE("StoreLock_HolderThatDied_BlocksNobody") {
  const Place place;
  place.make();
  ChildProcess holder([&] {
    new Store(place.open(true));  // as if killed: never destroyed
    return 7;
  });
  CHECK(holder.run() == 7);
  CHECK(place.open(true).sequence() == 1);
}

TEST_CASE("StoreCreate_WhereAWriterDiedInItsManifest_TakesThePlace") {
  const Place place;
  std::filesystem::create_directory(place.path);
  File(place.path / "manifest", OpenMode::kCreate).close();
  CHECK_FALSE(Store::has_commit(place.path));
  place.make();
  CHECK(Store::has_commit(place.path));
}

TEST_CASE("StoreCreate_WhereSomebodyElseIsCreating_LeavesTheirsAlone") {
  const Place place;
  std::filesystem::create_directory(place.path);
  const Directory theirs(place.path);
  REQUIRE(theirs.lock(false));
  create_begun_manifest(theirs, false);
  CHECK_THROWS_AS(place.make(), Error);
  CHECK(file_names(place.path) == Names{"manifest"});
}

TEST_CASE("ReplaceFile_StoreThatHasMovedOn_IsRefused") {
  const Place place;
  place.make();
  {
    Store store = place.open(true);
    commit_anew(store);
  }
  const std::filesystem::path image = place.path.parent_path() / "spare";
  File(image, OpenMode::kCreate).close();
  const auto replace = [&](std::uint64_t version) {
    replace_file(place.path, version, "spare", Directory(image.parent_path()));
  };
  CHECK_THROWS_AS(replace(1), Error);
  CHECK(std::filesystem::exists(image));
  replace(2);
  CHECK_FALSE(std::filesystem::exists(image));
}

TEST_CASE("StoreClose_Writer_LetsTheNextOneIn") {
  const Place place;
  place.make();
  Store store = place.open(true);
  store.close();
  CHECK(place.open(true).sequence() == 1);
}

TEST_CASE("Store_OpenedForReading_RefusesChanges") {
  const Place place;
  {
    Store store = place.create("mmap");
    add_sample(store, sample_schemas()[0], 1);
    add_sample(store, sample_schemas()[1], 1);
    store.commit();
  }
  Store store = place.open();
  const Names before = file_names(place.path);
  const std::function<void()> changes[] = {
      [&] { store.add_attribute(sample_schemas()[2]); }, [&] { store.add_level(0); },
      [&] { store.replace_attribute(0, 1); }, [&] { store.commit(); }};
  for (const auto& change : changes) {
    const Error error = error_of(change);
    CHECK(error.code() == ErrorCode::kBadState);
    CHECK(names(error, {place.path.string(), "opened for reading"}));
  }
  CHECK(file_names(place.path) == before);
  CHECK(store.attributes().size() == 2);
  CHECK(holds_sample(store, 0));
}

TEST_CASE("StoreAddAttribute_NameOrTypeThatCannotBe_IsRefused") {
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  store.add_attribute({"position", ComponentType::kFloat32, 3});
  const auto code = [&](AttributeSchema schema) {
    return error_of([&] { store.add_attribute(std::move(schema)); }).code();
  };
  CHECK(code({"position", ComponentType::kUint8, 1}) == ErrorCode::kInvalidArgument);
  CHECK(code({"", ComponentType::kFloat32, 3}) == ErrorCode::kInvalidArgument);
  CHECK(code({std::string(256, 'x'), ComponentType::kFloat32, 3}) == ErrorCode::kInvalidArgument);
  CHECK(code({"../x", ComponentType::kFloat32, 3}) == ErrorCode::kInvalidArgument);
  CHECK(code({"x", ComponentType::kFloat32, 0}) == ErrorCode::kInvalidArgument);
  CHECK(code({"x", ComponentType::kFloat32, 256}) == ErrorCode::kInvalidArgument);
  CHECK(code({"x", static_cast<ComponentType>(11), 1}) == ErrorCode::kInvalidArgument);
  store.add_attribute({std::string(31, 'x'), ComponentType::kUint64, 255});
}

TEST_CASE("Store_OfSeveralHundredAttributes_IsReadAsWritten") {
  const Place place;
  {
    Store store = place.create("pread", tetrahedron());
    for (int i = 0; i < 300; ++i)
      add_sample(store, {fmt::format("a{}", i), ComponentType::kUint8, 1}, i % 50 == 0 ? 1 : 0);
    store.commit();
  }
  Store store = place.open();
  REQUIRE(store.attributes().size() == 300);
  for (AttributeId id = 0; id < 300; ++id) CHECK(holds_sample(store, id));
}

TEST_CASE("StoreAttribute_UnknownNameOrOtherType_NamesWhatThereIs") {
  Store store = Store::create({}, BaseMesh::build(tetrahedron()), sample_options("memory"),
                              default_backends());
  CHECK(names(error_of([&] { store.attribute("normal"); }), {"'normal'", "none"}));
  add_sample(store, sample_schemas()[0], 0);
  add_sample(store, sample_schemas()[1], 0);
  const Error unknown = error_of([&] { store.attribute("normal"); });
  CHECK(unknown.code() == ErrorCode::kNotFound);
  CHECK(names(unknown, {"'normal'", "position, mass"}));
  CHECK(store.base_records<Vector3<float>>(0).size() == 4);
  CHECK(store.base_records<double>(1).size() == 4);
  const Error other = error_of([&] { store.base_records<float>(1); });
  CHECK(other.code() == ErrorCode::kInvalidArgument);
  CHECK(names(other, {"'mass'", "float64 x 1", "float32 x 1"}));
}

TEST_CASE("LevelFiles_ClosedMesh_HoldExactlyTheirRecordsButForPadding") {
  for (const std::string backend : {"pread", "mmap"}) {
    const Place place;
    Store store = place.create(backend, icosahedron());
    add_sample(store, sample_schemas()[0], 5);
    store.commit();
    for (int level = 1; level <= 5; ++level) {
      const std::uint64_t raw_bytes = 30 * (std::uint64_t{1} << (2 * (level - 1))) * 12;
      const auto file = place.path / fmt::format("attribute0.level0{}.1", level);
      CHECK(std::filesystem::file_size(file) == (raw_bytes + 4095) / 4096 * 4096);
      const std::vector<std::byte> bytes = file_bytes(file);
      const std::vector<std::byte> expected = sample_level(store, sample_schemas()[0], level);
      REQUIRE(expected.size() == raw_bytes);
      CHECK(std::equal(expected.begin(), expected.end(), bytes.begin()));
      CHECK(std::all_of(bytes.begin() + static_cast<std::ptrdiff_t>(raw_bytes), bytes.end(),
                        [](std::byte byte) { return byte == std::byte{0}; }));
    }
  }
}

TEST_CASE("LevelFiles_MeshWithBorder_WasteNothing") {
  for (const std::string backend : {"pread", "mmap"}) {
    const Place place;
    const BaseMesh base = BaseMesh::build(random_sheet(9, 120));
    const std::uint64_t border = base.border_edge_count();
    REQUIRE(border > 10);
    Store store = place.create(backend, random_sheet(9, 120));
    add_sample(store, sample_schemas()[0], 4);
    store.commit();
    std::uint64_t vertices = base.vertex_count();
    for (int level = 1; level <= 4; ++level) {
      const std::uint64_t n = std::uint64_t{1} << (level - 1);
      const std::uint64_t records = (base.edge_count() - border) * n * n + border * n * (n + 1) / 2;
      vertices += records;
      CHECK(counts_at_level(base, level).vertices == vertices);
      const auto file = place.path / fmt::format("attribute0.level0{}.1", level);
      CHECK(std::filesystem::file_size(file) == (records * 12 + 4095) / 4096 * 4096);
      const std::vector<std::byte> bytes = file_bytes(file);
      const std::vector<std::byte> expected = sample_level(store, sample_schemas()[0], level);
      CHECK(std::equal(expected.begin(), expected.end(), bytes.begin()));
    }
  }
}

TEST_CASE("StoreStoredBytes_OnDisk_CountsBaseRecordsAndLevels") {
  const Place place;
  Store store = place.create("pread", icosahedron());
  add_sample(store, sample_schemas()[0], 2);
  store.commit();
  const std::uint64_t base_mesh = std::filesystem::file_size(place.path / "base.mesh");
  CHECK(store.info().stored_bytes == base_mesh + 12 * 12 + 2 * 4096);
}

TEST_CASE("StoreOpenedForReading_PinnedForWriting_IsRefusedOnEveryBackend") {
  for (const std::string& backend : durable_backends()) {
    CAPTURE(backend);
    const Place place;
    {
      Store store = place.create(backend);
      add_sample(store, sample_schemas()[0], 2);
      store.commit();
    }
    Store reader = Store::open(place.path, {}, default_backends());
    for (const Access access : {Access::kOverwrite, Access::kUpdate}) {
      const Error error = error_of([&] {
        StoreAccess::open_session(reader).pin(StoreAccess::level_file(reader, 0, 2), 0, access);
      });
      CHECK(error.code() == ErrorCode::kBadState);
      CHECK(names(error,
                  {StoreAccess::level_file(reader, 0, 2).path.string(), "opened for reading"}));
    }
    CHECK(holds_sample(reader, 0));
  }
}

TEST_CASE("Store_MovedFrom_LivesOnInItsNewPlace") {
  const Place place;
  Store first = place.create("pread");
  add_sample(first, sample_schemas()[0], 2);
  Store second = std::move(first);
  CHECK(holds_sample(second, 0));
  const Place other;
  Store third = other.create("compressed");
  third = std::move(second);
  CHECK_FALSE(std::filesystem::exists(other.path));  // it was never committed
  third.commit();
  CHECK(holds_sample(third, 0));
}

TEST_CASE("Store_AttributeOrLevelThatIsNotThere_IsRefusedInWords") {
  Store store = Store::create({}, BaseMesh::build(octahedron()), sample_options("memory"),
                              default_backends());
  const AttributeId id = add_sample(store, sample_schemas()[0], 2);
  const Store& reading = store;
  const std::vector<std::function<void()>> calls = {
      [&] { StoreAccess::level_file(store, 1, 1); },
      [&] { StoreAccess::level_file(reading, 1, 1); },
      [&] { store.base_bytes(1); },
      [&] { reading.base_bytes(1); },
      [&] { store.add_level(kNoId); },
      [&] { store.set_pipeline(1, "none"); },
      [&] { store.replace_attribute(id, 1); },
      [&] { store.replace_attribute(1, id); },
      [&] { StoreAccess::check_type(store, 1, ComponentType::kFloat32, 3); }};
  for (const auto& call : calls) {
    const Error error = error_of(call);
    CHECK(error.code() == ErrorCode::kInvalidArgument);
    CHECK(names(error, {"an attribute below 1", "found"}));
  }
  for (const int level : {-1, 0, 3, 1000})
    for (const auto& call :
         std::vector<std::function<void()>>{[&] { StoreAccess::level_file(store, id, level); },
                                            [&] { StoreAccess::level_file(reading, id, level); }}) {
      const Error error = error_of(call);
      CHECK(error.code() == ErrorCode::kInvalidArgument);
      CHECK(names(error, {"level " + std::to_string(level), "1 to 2"}));
    }
}
