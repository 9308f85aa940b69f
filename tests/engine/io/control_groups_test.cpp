#include "io/control_groups.h"

#include <sched.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "plait/progress.h"
#include "support/temporary_directory.h"

using namespace plait;

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
