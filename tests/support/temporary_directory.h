// tests/support/temporary_directory.h: makes a directory for a test. The destructor removes it.
#pragma once

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>

namespace plait::test {

/// The kind of file system for a test's files.
enum class Medium : std::uint8_t {
  kDisk,  ///< the machine's directory for temporary files
  /// A file system in memory if there is one: for tests that make many small stores and do not
  /// test the disk.
  kMemory,
};

/// The directory for temporary files on this medium. If TMPDIR is set in the environment, it is
/// used for both. A file system in memory must have O_DIRECT (Linux 6.6), which backends use, and
/// space for tests that run at the same time.
inline std::filesystem::path temporary_files(Medium medium) {
  static const bool has_memory = [] {
    constexpr std::uintmax_t kRoomBytes = 1 << 30;
    std::error_code none;
    const std::filesystem::space_info space = std::filesystem::space("/dev/shm", none);
    if (none || space.available < kRoomBytes) return false;
    const int file = ::open("/dev/shm", O_TMPFILE | O_RDWR | O_DIRECT | O_CLOEXEC, 0600);
    if (file >= 0) ::close(file);
    return file >= 0;
  }();
  if (medium == Medium::kMemory && has_memory && ::getenv("TMPDIR") == nullptr) return "/dev/shm";
  return std::filesystem::temp_directory_path();
}

class TemporaryDirectory {
 public:
  explicit TemporaryDirectory(Medium medium = Medium::kDisk) {
    std::string name = (temporary_files(medium) / "plait-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::system_error(errno, std::generic_category(), name);
    path_ = name;
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace plait::test
