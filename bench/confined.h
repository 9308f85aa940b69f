// bench/confined.h: runs work in a child process, under a memory limit, with a cold page cache.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace plait::bench {

/// A cgroup (version 1) with a memory limit. The destructor removes it. If the cgroup cannot be
/// made, limited() returns false and run() runs without a limit.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::uint64_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
  bool limited() const { return !group_.empty(); }

  /// Runs `work` in a child process inside the group and returns its result. Errors: kIo if the
  /// child failed.
  double run(const std::function<double()>& work) const;
  /// The same for work with several figures, at most 256.
  std::vector<double> run_for_figures(const std::function<std::vector<double>()>& work) const;

 private:
  std::filesystem::path group_;
};

/// Writes dirty pages to the disk and drops the page cache. Returns false if that is not permitted;
/// then it drops only the pages of `files` (posix_fadvise).
bool make_cold(const std::vector<std::filesystem::path>& files);

/// The output of a command; empty if the command fails or is missing.
std::string output_of(const std::string& command);

}  // namespace plait::bench
