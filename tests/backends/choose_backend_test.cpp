#include "plait/backends/choose_backend.h"

#include <catch2/catch.hpp>
#include <string>

#include "plait/backends/registry.h"
#include "plait/error.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kAvailable = std::uint64_t{8} << 30;
constexpr std::uint64_t kLarge = kAvailable / kLargeStoreDivisor + 1;

/// pread, and a uring that its kernel refuses or allows.
BackendRegistry registry_with_uring(bool allowed) {
  BackendRegistry registry;
  registry.add(default_backends().find("pread"));
  BackendRegistry::Entry uring = default_backends().find("uring");
  uring.validate = [allowed](std::string_view) {
    if (!allowed) throw Error(ErrorCode::kNotSupported, "the kernel refuses io_uring");
  };
  registry.add(uring);
  return registry;
}

}  // namespace

TEST_CASE("ChooseBackend_Facts_DecideByTheFirstRuleThatIsTrue") {
  const BackendFacts large{kLarge, kAvailable, StoreMedium::kDisk, "", ""};
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
      {"small on a disk", with([](BackendFacts& facts) { facts.raw_bytes = kLarge - 1; }), "pread",
       "the page cache keeps it"},
      {"an empty store", with([](BackendFacts& facts) { facts.raw_bytes = 0; }), "pread", "small"},
      {"in memory", with([](BackendFacts& facts) { facts.medium = StoreMedium::kMemory; }), "pread",
       "keeps files in memory"},
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
  // Nothing is known: pread.
  CHECK(choose_backend(BackendFacts{}).name == "pread");
}

TEST_CASE("ChooseBackend_SmallStore_IsPreadAndSaysBesideWhat") {
  const TemporaryDirectory here;
  const BackendChoice choice =
      choose_backend(registry_with_uring(true), here.path() / "s.plait", kLarge - 1, kAvailable);
  CHECK(choice.name == "pread");
  CHECK_THAT(choice.reason, Catch::Contains("small") && Catch::Contains("512 MiB of levels") &&
                                Catch::Contains("8192 MiB of memory"));
}

TEST_CASE("ChooseBackend_LargeStoreOnADisk_IsUringUnlessTheKernelRefuses") {
  const TemporaryDirectory here;
  const std::filesystem::path path = here.path() / "s.plait";
  const BackendChoice refused =
      choose_backend(registry_with_uring(false), path, kLarge, kAvailable);
  CHECK(refused.name == "pread");
  CHECK_THAT(refused.reason, Catch::Contains("the kernel refuses io_uring"));
  const BackendChoice choice = choose_backend(registry_with_uring(true), path, kLarge, kAvailable);
  // Temporary files may be in memory here.
  if (choice.name == "pread")
    CHECK_THAT(choice.reason, Catch::Contains("file system"));
  else
    CHECK_THAT(choice.reason, Catch::Contains("large"));
  CHECK(std::filesystem::is_empty(here.path()));
}

TEST_CASE("ChooseBackend_WhereItCannotBeHad_IsPreadAndSaysWhy") {
  CHECK_THAT(
      choose_backend(registry_with_uring(true), "/dev/shm/s.plait", kLarge, kAvailable).reason,
      Catch::Contains("keeps files in memory"));
  CHECK(choose_backend(registry_with_uring(true), "/no/such/s.plait", kLarge, kAvailable).name ==
        "pread");
  BackendRegistry without;
  without.add(default_backends().find("pread"));
  CHECK(choose_backend(without, "s.plait", kLarge, kAvailable).name == "pread");
}

}  // namespace plait::test
