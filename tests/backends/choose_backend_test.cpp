#include "choose_backend.h"

#include <catch2/catch.hpp>
#include <string>

#include "plait/error.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "support/files_in_memory.h"
#include "support/skip.h"
#include "support/temporary_directory.h"
#include "support/test_meshes.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kAvailable = std::uint64_t{8} << 30;
constexpr std::uint64_t kLarge = kAvailable / kLargeStoreDivisor + 1;

/// pread, mmap, and a uring that its kernel refuses or allows.
BackendRegistry registry_with_uring(bool allowed) {
  BackendRegistry registry;
  registry.add(default_backends().find("pread"));
  registry.add(default_backends().find("mmap"));
  RegisteredBackend uring = default_backends().find("uring");
  uring.check_machine = [allowed] {
    if (!allowed) throw Error(ErrorCode::kNotSupported, "the kernel refuses io_uring");
  };
  registry.add(uring);
  return registry;
}

NewStore large_store(const std::filesystem::path& path) {
  return {.path = path, .level_bytes = kLarge, .available_bytes = kAvailable};
}

}  // namespace

TEST_CASE("BackendFacts_PathThatEndsWithASlash_AreThoseWithoutIt") {
  const TemporaryDirectory directory;
  const auto medium = [&](const char* name) {
    return backend_facts(default_backends(), large_store(directory.path() / name)).medium;
  };
  CHECK(medium("new.plait") != StoreMedium::kUnknown);
  CHECK(medium("new.plait/") == medium("new.plait"));
}

TEST_CASE("ChooseBackend_Facts_DecideByTheFirstRuleThatIsTrue") {
  const BackendFacts large{
      .level_bytes = kLarge, .available_bytes = kAvailable, .medium = StoreMedium::kDisk};
  struct Row {
    const char* what;
    BackendFacts facts;
    const char* backend;
    const char* because;
  };
  const auto with = [&](auto change) {
    BackendFacts facts = large;
    change(facts);
    return facts;
  };
  const Row rows[] = {
      {"large on a disk", large, "uring", "goes past the page cache"},
      {"small on a disk", with([](BackendFacts& facts) { facts.level_bytes = kLarge - 1; }),
       "pread", "the page cache keeps it"},
      {"an empty store", with([](BackendFacts& facts) { facts.level_bytes = 0; }), "pread",
       "small"},
      {"in memory", with([](BackendFacts& facts) { facts.medium = StoreMedium::kMemory; }), "mmap",
       "keeps files in memory"},
      {"in memory, small", with([](BackendFacts& facts) {
         facts.medium = StoreMedium::kMemory;
         facts.level_bytes = 0;
       }),
       "mmap", "keeps files in memory"},
      {"in memory, and none maps", with([](BackendFacts& facts) {
         facts.medium = StoreMedium::kMemory;
         facts.no_mmap = "there is no mapping here";
       }),
       "pread", "there is no mapping here"},
      {"a network", with([](BackendFacts& facts) { facts.medium = StoreMedium::kNetwork; }),
       "pread", "on another machine"},
      {"no medium", with([](BackendFacts& facts) { facts.medium = StoreMedium::kUnknown; }),
       "pread", "nothing is known"},
      {"no io_uring", with([](BackendFacts& facts) { facts.no_uring = "the kernel says no"; }),
       "pread", "the kernel says no"},
      {"no O_DIRECT", with([](BackendFacts& facts) { facts.no_direct = "no O_DIRECT here"; }),
       "pread", "no O_DIRECT here"},
      {"no memory is known", with([](BackendFacts& facts) { facts.available_bytes = ~0ull; }),
       "pread", "an unknown amount of memory"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.what);
    const BackendChoice choice = choose_backend(row.facts);
    CHECK(choice.name == row.backend);
    CHECK_THAT(choice.reason, Catch::Contains(row.because) && Catch::Contains("of levels"));
  }
  BackendFacts with_pipelines = large, without_path = large;
  with_pipelines.has_pipelines = without_path.in_memory = true;
  CHECK(choose_backend(with_pipelines).name == "compressed");
  CHECK(choose_backend(without_path).name == "memory");
  // Nothing is known: pread.
  CHECK(choose_backend(BackendFacts{}).name == "pread");
}

TEST_CASE("ChooseBackend_SmallStore_IsPreadAndSaysBesideWhat") {
  const TemporaryDirectory here;
  const BackendChoice choice = choose_backend(
      registry_with_uring(true),
      {.path = here.path() / "s.plait", .level_bytes = kLarge - 1, .available_bytes = kAvailable});
  CHECK(choice.name == (keeps_files_in_memory(here.path()) ? "mmap" : "pread"));
  CHECK_THAT(choice.reason, Catch::Contains("small") && Catch::Contains("4096 MiB of levels") &&
                                Catch::Contains("8192 MiB of memory"));
}

TEST_CASE("ChooseBackend_LargeStoreOnADisk_IsUringUnlessTheKernelRefuses") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  const BackendChoice choice = choose_backend(registry_with_uring(true), large_store(path)),
                      refused = choose_backend(registry_with_uring(false), large_store(path));
  if (keeps_files_in_memory(here.path())) {
    CHECK(choice.name == "mmap");
    CHECK(refused.name == "mmap");
  } else {
    CHECK(refused.name == "pread");
    CHECK_THAT(refused.reason, Catch::Contains("the kernel refuses io_uring"));
    CHECK_THAT(choice.reason, Catch::Contains("large"));
    if (choice.name == "pread") CHECK_THAT(choice.reason, Catch::Contains("file system"));
  }
  CHECK(std::filesystem::is_empty(here.path()));
}

TEST_CASE("ChooseBackend_FilesInMemory_AreMappedUnlessNoBackendMaps") {
  if (!keeps_files_in_memory("/dev/shm")) return skip("/dev/shm is not in memory");
  const BackendChoice choice = choose_backend(registry_with_uring(true), large_store("/dev/shm/s"));
  CHECK(choice.name == "mmap");
  CHECK_THAT(choice.reason, Catch::Contains("keeps files in memory"));
  BackendRegistry without;
  without.add(default_backends().find("pread"));
  const BackendChoice other = choose_backend(without, large_store("/dev/shm/s"));
  CHECK(other.name == "pread");
  CHECK_THAT(other.reason, Catch::Contains("\"mmap\""));
}

TEST_CASE("ChooseBackend_WhereNothingIsKnown_IsPread") {
  CHECK(choose_backend(registry_with_uring(true), large_store("/no/such/s.plait")).name == "pread");
  BackendRegistry without;
  without.add(default_backends().find("pread"));
  CHECK(choose_backend(without, large_store("s.plait")).name == "pread");
}

TEST_CASE("StoreOptions_WithoutABackend_GetTheChoiceOfTheRegistry") {
  const TemporaryDirectory here;
  const auto backend_of = [](const std::filesystem::path& path, const StoreOptions& options,
                             const BackendRegistry& backends) {
    return Store::create(path, BaseMesh::build(tetrahedron()), options, backends).options().backend;
  };
  CHECK(backend_of(here.path() / "a", {}, default_backends()) ==
        (keeps_files_in_memory(here.path()) ? "mmap" : "pread"));
  CHECK(backend_of({}, {}, default_backends()) == "memory");
  CHECK(backend_of(here.path() / "b", {.pipeline = "shuffle,zstd:1"}, default_backends()) ==
        "compressed");
  BackendRegistry asked = default_backends();
  std::uint64_t bytes = 0;
  asked.set_chooser([&](const BackendRegistry&, const NewStore& store) -> BackendChoice {
    bytes = store.level_bytes;
    return {"compressed", "the test says so"};
  });
  CHECK(backend_of(here.path() / "c", {.expected_bytes = 77}, asked) == "compressed");
  CHECK(bytes == 77);
  asked.set_chooser({});
  CHECK_THROWS_WITH(backend_of(here.path() / "d", {}, asked), Catch::Contains("auto"));
}

}  // namespace plait::test
