#include "instrument/scratch_directory.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <optional>
#include <stop_token>
#include <thread>

#include "instrument/memory_limit.h"
#include "io/made_mark.h"
#include "plait/error.h"
#include "support/temporary_directory.h"

namespace plait::instrument {
namespace {

namespace fs = std::filesystem;

/// Runs `work` in a process that ends without destructors, as one that is killed.
template <class Work>
void in_killed_process(Work work) {
  const pid_t child = ::fork();
  if (child == 0) {
    work();
    ::kill(::getpid(), SIGKILL);
  }
  ::waitpid(child, nullptr, 0);
}

TEST_CASE("the next run removes what a killed run left, and nothing that is in use") {
  const test::TemporaryDirectory place;
  in_killed_process([&] {
    static std::optional<ScratchDirectory> left(place.path());
    std::ofstream(left->path() / "file") << "data";
  });
  std::vector<FoundScratch> found = find_scratch(place.path(), false);
  REQUIRE(found.size() == 1);
  CHECK_FALSE(found[0].in_use);
  CHECK(found[0].bytes > 4);
  const ScratchDirectory first(place.path());
  CHECK_FALSE(fs::exists(place.path() / found[0].name));
  {
    const ScratchDirectory second(place.path());
    CHECK(fs::exists(first.path()));
    CHECK(find_scratch(place.path(), true).size() == 2);
    CHECK(fs::exists(second.path()));
  }
  found = find_scratch(place.path(), true);
  REQUIRE(found.size() == 1);
  CHECK(found[0].in_use);
  CHECK_FALSE(found[0].removed);
}

TEST_CASE("a directory without the mark is not ours, whatever its name") {
  const test::TemporaryDirectory place;
  fs::create_directory(place.path() / "plait-scratch-mine");
  std::ofstream(place.path() / "plait-scratch-mine" / "file") << "data";
  std::ofstream(place.path() / "plait-scratch-mine" / "plait-made") << "notes of my own";
  fs::create_directory(place.path() / "other");
  write_made_mark(Directory(place.path() / "other"));
  CHECK(find_scratch(place.path(), true).empty());
  CHECK(fs::exists(place.path() / "plait-scratch-mine" / "file"));
  CHECK(fs::exists(place.path() / "other"));
  CHECK_THROWS_AS(ScratchDirectory(place.path() / "absent"), Error);
}

TEST_CASE("control groups of dead runs are removed, and not those in use") {
  // Directories stand in for groups, which need privileges.
  const test::TemporaryDirectory groups;
  const MemoryLimit::Places places{.v1 = groups.path(), .v2 = {}};
  std::ofstream(groups.path() / "memory.limit_in_bytes") << "0";
  fs::create_directory(groups.path() / "plait-bench-1-1");
  const fs::path used = groups.path() / "plait-bench-1-2";
  fs::create_directory(used);
  const Directory lock(used);
  REQUIRE(lock.lock(true));
  CHECK(MemoryLimit::dead_groups(false, places).size() == 1);
  CHECK(MemoryLimit::dead_groups(true, places).size() == 1);
  CHECK_FALSE(fs::exists(groups.path() / "plait-bench-1-1"));
  CHECK(fs::exists(used));
}

TEST_CASE("a group is made although others look for dead groups all the time") {
  const test::TemporaryDirectory groups;
  const MemoryLimit::Places places{.v1 = groups.path(), .v2 = {}};
  std::ofstream(groups.path() / "memory.limit_in_bytes") << "0";
  const std::jthread others([&](const std::stop_token& ended) {
    while (!ended.stop_requested()) {
      MemoryLimit::dead_groups(true, places);
      std::this_thread::yield();
    }
  });
  int limited = 0;
  for (int made = 0; made < 100; ++made) {
    limited += MemoryLimit(1 << 20, places).limited();
    std::error_code gone;
    for (const fs::directory_entry& entry : fs::directory_iterator(groups.path()))
      if (entry.is_directory(gone)) fs::remove_all(entry.path(), gone);
  }
  CHECK(limited == 100);
}

}  // namespace
}  // namespace plait::instrument
