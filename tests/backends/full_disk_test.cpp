// What a backend does when the file cannot grow, tried with the process's own limit of file sizes
// (RLIMIT_FSIZE), which needs no privilege.
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <catch2/catch.hpp>

#include "backends/conformance.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "support/usable_backends.h"

namespace plait::test {
namespace {

class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t bytes) {
    former_handler_ = ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &former_);
    const rlimit limit{bytes, former_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &former_);
    ::signal(SIGXFSZ, former_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit former_{};
  void (*former_handler_)(int) = nullptr;
};

}  // namespace

TEST_CASE("RawBackendCreate_NoRoomForTheFile_IsAnErrorAndLeavesNoFile") {
  for (const std::string& name : usable_backends()) {
    if (name == "memory" || name == "compressed") continue;  // no file, and one that grows
    const BackendUnderTest subject{name, default_backends().find(name)};
    LevelUnderTest level(subject);
    const FileSizeLimit limit(8192);
    CHECK_THROWS_AS(level.open(), Error);
    CHECK_FALSE(std::filesystem::exists(level.file()));
  }
}

TEST_CASE("PreallocatingBackendCreate_NewLevel_HasAllItsDiskBlocks") {
  for (const std::string& name : usable_backends()) {
    if (name != "mmap" && name != "uring") continue;
    const BackendUnderTest subject{name, default_backends().find(name)};
    LevelUnderTest level(subject, {64, {}, 6, 12, 1 << 16});
    level.open();
    struct stat status {};
    REQUIRE(::stat(level.file().c_str(), &status) == 0);
    CHECK(static_cast<std::uint64_t>(status.st_size) ==
          (level.geometry().total_bytes() + 4095) / 4096 * 4096);
    CHECK(status.st_blocks * 512 >= status.st_size);  // st_blocks counts 512 bytes everywhere
  }
}

TEST_CASE("CompressedWrite_NoRoomForAnExtent_KeepsTheBlockAndTheSpace") {
  const BackendUnderTest subject{"compressed", default_backends().find("compressed"), "lz4"};
  LevelUnderTest level(subject);
  Backend& backend = level.open();
  const std::uint64_t bytes = level.geometry().block_bytes(0);
  const auto content = make_content(bytes, Content::kRandom, 1);
  backend.write({0, 1}, content);
  const std::uint64_t stored_bytes = backend.stored_bytes();
  {
    const FileSizeLimit limit(stored_bytes);
    CHECK_THROWS_AS(backend.write({0, 1}, make_content(bytes, Content::kRandom, 2)), Error);
    CHECK_THROWS_AS(backend.write({1, 1}, make_content(bytes, Content::kRandom, 3)), Error);
  }
  CHECK(backend.stored_bytes() == stored_bytes);
  CHECK(level.table()[1].encoding == BlockEncoding::kNeverWritten);
  CHECK(read_blocks(backend, level.geometry(), {0, 1}) == content);
  const auto fresh = make_content(bytes, Content::kRandom, 4);
  backend.write({0, 1}, fresh);
  CHECK(read_blocks(backend, level.geometry(), {0, 1}) == fresh);
}

}  // namespace plait::test
