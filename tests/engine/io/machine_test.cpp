// The memory and the processors that this process may use.
#include "io/machine.h"

#include <sched.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "io/control_groups.h"
#include "plait/progress.h"
#include "support/resource_limit.h"
#include "support/skip.h"
#include "support/temporary_directory.h"

namespace plait::test {
namespace {

constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();

std::uint64_t total_memory_bytes() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t address_space_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t pages = 0;
  statm >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

TEST_CASE("AvailableMemory_OfThisMachine_IsPartOfItsMemory") {
  CHECK(available_memory_bytes() > 0);
  CHECK(available_memory_bytes() <= total_memory_bytes());
}

TEST_CASE("AvailableMemory_AddressSpaceLimited_IsWhatTheLimitLeaves") {
  if (!kAddressSpaceCanBeLimited) {
    skip("sanitizers need the address space");
    return;
  }
  constexpr std::uint64_t kLeft = 32 << 20;
  const std::uint64_t taken = address_space_bytes();
  const ResourceLimit limit(RLIMIT_AS, taken + kLeft);
  CHECK(available_memory_bytes() <= kLeft + (1 << 20));
  CHECK(available_memory_bytes() > 0);
}

TEST_CASE("FreeDisk_OfWhatIsNotThereYet_IsThatOfTheDirectoryAbove") {
  const TemporaryDirectory here;
  struct statvfs status {};
  REQUIRE(::statvfs(here.path().c_str(), &status) == 0);
  const std::uint64_t size = static_cast<std::uint64_t>(status.f_blocks) * status.f_frsize;
  for (const std::filesystem::path& path :
       {here.path(), here.path() / "a", here.path() / "a" / "b"}) {
    CHECK(free_disk_bytes(path) > 0);
    CHECK(free_disk_bytes(path) <= size);
  }
  // A file system without blocks does not know.
  CHECK(free_disk_bytes("/proc/self/no/such") == std::numeric_limits<std::uint64_t>::max());
  CHECK(free_disk_bytes("not-there") > 0);
}

TEST_CASE("LargestFile_Limited_IsTheLimit") {
  {
    const ResourceLimit limit(RLIMIT_FSIZE, 12345678);
    CHECK(largest_file_bytes() == 12345678);
  }
  CHECK(largest_file_bytes() == kAny);
}

namespace {

class Groups {
 public:
  explicit Groups(const std::string& lines) {
    std::filesystem::create_directory(here_.path() / "mounted");
    std::ofstream(here_.path() / "groups") << lines;
  }
  Groups& with(const std::string& name, const std::string& content) {
    const std::filesystem::path path = here_.path() / "mounted" / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << content;
    return *this;
  }
  ControlGroupFiles files() const { return {here_.path() / "groups", here_.path() / "mounted"}; }

 private:
  test::TemporaryDirectory here_;
};

/// What `work` returns in a thread that may run on the first `processors` of those of the machine.
template <class Work>
int with_processors(int processors, Work work) {
  int result = 0;
  std::thread([&] {
    cpu_set_t set;
    CPU_ZERO(&set);
    REQUIRE(::sched_getaffinity(0, sizeof set, &set) == 0);
    int kept = 0;
    for (std::size_t each = 0; each < CPU_SETSIZE; ++each)
      if (CPU_ISSET(each, &set) && kept++ >= processors) CPU_CLR(each, &set);
    REQUIRE(::sched_setaffinity(0, sizeof set, &set) == 0);
    result = work();
  }).join();
  return result;
}

int all_processors() { return usable_processors(Groups("").files()); }

}  // namespace

TEST_CASE("UsableProcessors_AnAffinity_IsKeptByTheDefaultOfThreads") {
  ::unsetenv("SLURM_CPUS_PER_TASK");
  CHECK(with_processors(1, [] { return usable_processors(); }) == 1);
  CHECK(with_processors(1, [] { return thread_count(0, "work"); }) == 1);
  CHECK(thread_count(7, "work") == 7);
}

TEST_CASE("UsableProcessors_QuotasOfBothVersions_AreTheLeastOfAllGroupsRoundedUp") {
  ::unsetenv("SLURM_CPUS_PER_TASK");
  const int all = all_processors();
  const auto usable = [](const Groups& groups) { return usable_processors(groups.files()); };
  CHECK(usable(Groups("0::/a/b\n")
                   .with("a/cpu.max", "50000 100000\n")
                   .with("a/b/cpu.max", "max 100000\n")) == 1);
  CHECK(usable(Groups("0::/\n").with("cpu.max", "100000 100000\n")) == 1);
  CHECK(usable(Groups("0::/a\n").with("a/cpu.max", "max 100000\n")) == all);
  CHECK(usable(Groups("0::/a\n").with("a/cpu.max", "100001 100000\n")) == std::min(all, 2));
  CHECK(usable(Groups("4:cpu,cpuacct:/job\n0::/\n")
                   .with("cpu/job/cpu.cfs_quota_us", "20000\n")
                   .with("cpu/job/cpu.cfs_period_us", "100000\n")) == 1);
  CHECK(usable(Groups("4:cpu,cpuacct:/job\n")
                   .with("cpu/job/cpu.cfs_quota_us", "-1\n")
                   .with("cpu/job/cpu.cfs_period_us", "100000\n")) == all);
  CHECK(usable(Groups("3:cpuset:/job\n")
                   .with("cpu/job/cpu.cfs_quota_us", "20000\n")
                   .with("cpu/job/cpu.cfs_period_us", "100000\n")) == all);
  CHECK(usable(Groups("no groups\n::\n")) == all);
  CHECK(usable(Groups("0::/a\n").with("a/cpu.max", "\xff?")) == all);
}

TEST_CASE("UsableProcessors_WhatSlurmGivesATask_IsKept") {
  const auto usable = [](const char* text) {
    REQUIRE(::setenv("SLURM_CPUS_PER_TASK", text, 1) == 0);
    const int found = all_processors();
    ::unsetenv("SLURM_CPUS_PER_TASK");
    return found;
  };
  const int all = all_processors();
  CHECK(usable("1") == 1);
  CHECK(usable("1000000") == all);
  for (const char* nonsense : {"", "0", "-4", "many"}) CHECK(usable(nonsense) == all);
}

}  // namespace plait::test
