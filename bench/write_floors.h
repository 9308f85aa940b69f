// Measures how long the machine takes to write bytes in the way of a backend, without computing
// them.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <boost/align/aligned_allocator.hpp>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "plait/error.h"
#include "plait/file.h"
#include "support.h"

namespace plait::bench {

enum class WriteMethod {
  kBuffered,  ///< pwrite into the page cache
  kBegun,     ///< the same, then sync_file_range after every part
  kMapped,    ///< memcpy into a mapping of a preallocated file, then msync
  kDirect,    ///< pwrite past the page cache into preallocated files
};

constexpr const char* to_string(WriteMethod method) {
  return method == WriteMethod::kBuffered ? "pwrite + fdatasync"
         : method == WriteMethod::kBegun  ? "pwrite + sync_file_range + fdatasync"
         : method == WriteMethod::kMapped ? "mapping + msync"
                                          : "O_DIRECT pwrite + fdatasync";
}

/// Writes files in a directory, one per thread, and measures the time.
class WriteFloor {
 public:
  static constexpr std::uint64_t kTransfer = 1 << 20;

  WriteFloor(std::filesystem::path directory, int threads)
      : directory_(std::move(directory)), threads_(threads), data_(64 * kTransfer) {
    for (std::size_t i = 0; i < data_.size(); ++i)
      data_[i] = static_cast<std::byte>(i * 2654435761u >> 13);
  }

  /// The seconds from creating the files until their bytes are on the disk. Errors: kIo, kNoSpace.
  double seconds_for(WriteMethod method, std::uint64_t bytes) {
    const std::uint64_t count = static_cast<std::uint64_t>(threads_);
    // Direct transfers are whole disk sectors.
    const std::uint64_t share = ((bytes + count - 1) / count + 4095) / 4096 * 4096;
    std::vector<std::filesystem::path> paths;
    for (int i = 0; i < threads_; ++i) {
      paths.push_back(directory_ / ("plait-bench.floor" + std::to_string(i)));
      std::filesystem::remove(paths.back());
    }
    std::vector<std::exception_ptr> failures(paths.size());
    const double result = seconds([&] {
      std::vector<std::jthread> writers;
      for (std::size_t i = 0; i < paths.size(); ++i)
        writers.emplace_back([&, i] {
          try {
            write(method, paths[i], share);
          } catch (...) {
            failures[i] = std::current_exception();
          }
        });
    });
    for (const std::filesystem::path& path : paths) std::filesystem::remove(path);
    for (const std::exception_ptr& failure : failures)
      if (failure) std::rethrow_exception(failure);
    return result;
  }

 private:
  void write(WriteMethod method, const std::filesystem::path& path, std::uint64_t bytes) const {
    File file(path, OpenMode::kCreate);
    if (method == WriteMethod::kMapped) {
      file.preallocate(bytes);
      write_mapped(file, bytes);
    } else {
      if (method == WriteMethod::kDirect) {
        file.preallocate(bytes);
        if (::fcntl(file.descriptor(), F_SETFL, O_DIRECT) != 0)
          throw system_error("write past the page cache", path.native(), errno);
      }
      for_each_transfer(bytes, [&](std::uint64_t at, std::span<const std::byte> part) {
        file.write_at(at, part);
        if (method == WriteMethod::kBegun &&
            ::sync_file_range(file.descriptor(), static_cast<off_t>(at),
                              static_cast<off_t>(part.size()), SYNC_FILE_RANGE_WRITE) != 0)
          throw system_error("write", path.native(), errno);
      });
    }
    file.sync();
    file.close();
  }

  void write_mapped(const File& file, std::uint64_t bytes) const {
    void* to = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file.descriptor(), 0);
    if (to == MAP_FAILED) throw system_error("map", file.path().native(), errno);
    for_each_transfer(bytes, [&](std::uint64_t at, std::span<const std::byte> part) {
      std::memcpy(static_cast<std::byte*>(to) + at, part.data(), part.size());
    });
    const int failed = ::msync(to, bytes, MS_SYNC) != 0 ? errno : 0;
    ::munmap(to, bytes);
    if (failed != 0) throw system_error("sync", file.path().native(), failed);
  }

  template <class Transfer>
  void for_each_transfer(std::uint64_t bytes, Transfer transfer) const {
    const std::span<const std::byte> data(data_);
    for (std::uint64_t at = 0; at < bytes; at += kTransfer)
      transfer(at, data.subspan(at % data.size(), std::min(kTransfer, bytes - at)));
  }

  std::filesystem::path directory_;
  int threads_;
  std::vector<std::byte, boost::alignment::aligned_allocator<std::byte, 4096>> data_;
};

}  // namespace plait::bench
