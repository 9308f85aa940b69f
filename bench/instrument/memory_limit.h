// bench/instrument/memory_limit.h: a memory limit around the processes of measurements, and the
// control that it holds. Without a limit, the page cache of the whole machine serves a "disk".
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/extend/directory.h"

namespace plait::instrument {

/// What the kernel counted in the group so far.
struct LimitFigures {
  std::uint64_t peak_bytes = 0;  ///< memory and page cache of the group
  std::uint64_t times_full = 0;  ///< how often the group had to give back memory
};

/// A cgroup with a memory limit: version 1 (memory.limit_in_bytes), else version 2 (memory.max)
/// where this process may make groups. If neither works, limited() is false, why_not() says why,
/// and processes run without a limit. The destructor removes the group. A lock on the group ends
/// with its process: the constructor removes the groups of dead runs.
class MemoryLimit {
 public:
  /// Where cgroups are mounted. `own_v2` is the group of this process (/proc/self/cgroup).
  struct Places {
    std::filesystem::path v1 = "/sys/fs/cgroup/memory";
    std::vector<std::filesystem::path> v2 = {};  ///< groups to make ours in, the first that works
    static Places of_this_machine();
  };

  /// REQUIRES: bytes > 0.
  explicit MemoryLimit(std::uint64_t bytes, const Places& places = Places::of_this_machine());
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

  /// The groups of dead runs, as paths; removed with `remove`.
  static std::vector<std::filesystem::path> dead_groups(
      bool remove, const Places& places = Places::of_this_machine());

  std::uint64_t bytes() const { return bytes_; }
  bool limited() const { return version_ != 0; }
  int version() const { return version_; }  ///< 1 or 2; 0 without a limit
  const std::string& why_not() const { return why_not_; }

  /// Puts this process into the group; for the child that runs the work. Does nothing without a
  /// limit. Errors: kIo.
  void enter() const;
  /// Sets the peak and the count back, where the kernel can. Figures after that are of later runs.
  void reset_figures() const;
  LimitFigures figures() const;

  /// The control: a process in the group touches a quarter more memory than the limit. Returns true
  /// if the kernel ended it or swapped its memory out, so that the group never held more than the
  /// limit. Takes as long as touching that memory. Only for a process without other threads.
  bool holds() const;

 private:
  std::uint64_t bytes_;
  std::filesystem::path group_;
  Directory lock_;  ///< of the group
  int version_ = 0;
  std::string why_not_;
};

}  // namespace plait::instrument
