#include "io/machine.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <string>

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

}  // namespace plait::test
