// tests/fuzz/memory_file.h: a file in memory, for readers that take a path.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>

namespace plait::fuzz {

class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("plait-fuzz", MFD_CLOEXEC)) { check(descriptor_ >= 0); }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /// Replaces the content of the file. const, because the content is no part of this object.
  void write(std::span<const std::uint8_t> bytes) const {
    check(::ftruncate(descriptor_, 0) == 0);
    while (!bytes.empty()) {
      const ssize_t put = ::write(descriptor_, bytes.data(), bytes.size());
      check(put > 0);
      bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
    check(::lseek(descriptor_, 0, SEEK_SET) == 0);
  }

  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  static void check(bool right) {
    if (!right) throw std::system_error(errno, std::generic_category(), "memory file");
  }

  int descriptor_;
};

/// Writes `size` bytes at `data` to the one memory file of the program, and returns its path.
inline std::filesystem::path path_of(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.write({data, size});
  return file.path();
}

}  // namespace plait::fuzz
