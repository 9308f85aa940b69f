// bench/confined.h: work in a process of its own, under a memory limit, on a cold page cache.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plait::bench {

/// A cgroup (version 1) with a memory limit, gone when destroyed. Where none can be made, limited()
/// says so and run() goes without.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  bool limited() const { return !group_.empty(); }

  /// What `work` returns in a child process inside the group. Errors: kIo if the child failed.
  double run(const std::function<double()>& work) const;

 private:
  std::filesystem::path group_;
};

/// Writes dirty pages out and drops the page cache. False: not permitted, and only the pages of
/// `files` were given up (posix_fadvise).
bool make_cold(const std::vector<std::filesystem::path>& files);

/// What a program prints, or nothing if it fails or is missing.
std::string output_of(const std::string& command);

}  // namespace plait::bench
