#include "instrument/memory_limit.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

#include "instrument/process.h"
#include "plait/error.h"

namespace plait::instrument {
namespace {

namespace fs = std::filesystem;

bool put(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  return file.good();
}

std::uint64_t number_in(const fs::path& path, const std::string& after = {}) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (after.empty()) {
    file >> number;
    return number;
  }
  for (std::string word; file >> word;)
    if (word == after && file >> number) return number;
  return 0;
}

constexpr std::string_view kGroupPrefix = "plait-bench-";

/// Groups have no name in common, also if a process makes several.
fs::path new_name() {
  static int made = 0;
  return fmt::format("{}{}-{}", kGroupPrefix, ::getpid(), ++made);
}

}  // namespace

MemoryLimit::Places MemoryLimit::Places::of_this_machine() {
  Places places;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);)
    if (line.starts_with("0::")) {
      for (const char* mount : {"/sys/fs/cgroup", "/sys/fs/cgroup/unified"})
        if (std::error_code failed; fs::exists(fs::path(mount) / "cgroup.controllers", failed)) {
          // A group with processes cannot give its children a controller, so the groups above it
          // are tried too.
          fs::path own = fs::path(mount + line.substr(3)).lexically_normal();
          for (; own.native().size() >= std::strlen(mount); own = own.parent_path())
            places.v2.push_back(own);
        }
    }
  return places;
}

std::vector<fs::path> MemoryLimit::dead_groups(bool remove, const Places& places) {
  std::vector<fs::path> parents = places.v2;
  parents.push_back(places.v1);
  std::vector<fs::path> dead;
  for (const fs::path& parent : parents) {
    std::error_code failed;
    for (const fs::directory_entry& entry : fs::directory_iterator(parent, failed)) {
      if (!entry.path().filename().native().starts_with(kGroupPrefix)) continue;
      try {
        // The kernel removes no group with a process in it.
        if (const Directory group(entry.path()); !group.lock(true)) continue;
        if (!remove || ::rmdir(entry.path().c_str()) == 0) dead.push_back(entry.path());
      } catch (const Error&) {  // it is gone
        continue;
      }
    }
  }
  return dead;
}

MemoryLimit::MemoryLimit(std::uint64_t bytes, const Places& places) : bytes_(bytes) {
  dead_groups(true, places);
  std::error_code failed;
  // A process that looks for dead groups may take this one between its making and its lock.
  const auto try_group = [&](const fs::path& parent, const char* file, int version) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      const fs::path group = parent / new_name();
      if (!fs::create_directory(group, failed)) return false;
      try {
        lock_ = Directory(group);
        if (!lock_.lock(true)) continue;
        if (put(group / file, std::to_string(bytes))) {
          group_ = group;
          version_ = version;
          return true;
        }
        if (::rmdir(group.c_str()) == 0) return false;  // the kernel refused the limit
      } catch (const Error&) {                          // it is gone
        continue;
      }
    }
    return false;
  };
  if (fs::exists(places.v1 / "memory.limit_in_bytes", failed) &&
      try_group(places.v1, "memory.limit_in_bytes", 1)) {
    put(group_ / "memory.memsw.limit_in_bytes", std::to_string(bytes));  // where swap is counted
    return;
  }
  for (const fs::path& parent : places.v2) {
    put(parent / "cgroup.subtree_control", "+memory");
    if (try_group(parent, "memory.max", 2)) {
      put(group_ / "memory.swap.max", "0");
      return;
    }
  }
  why_not_ = "no memory cgroup of version 1 or 2 that this process may make a group in";
}

MemoryLimit::~MemoryLimit() {
  if (limited()) ::rmdir(group_.c_str());
}

void MemoryLimit::enter() const {
  if (limited() && !put(group_ / "cgroup.procs", std::to_string(::getpid())))
    throw Error(ErrorCode::kIo, "enter " + group_.native() + ": refused");
}

void MemoryLimit::reset_figures() const {
  if (version_ == 1) {
    put(group_ / "memory.force_empty", "0");  // pages that an earlier run left
    put(group_ / "memory.max_usage_in_bytes", "0");
    put(group_ / "memory.failcnt", "0");
  } else if (version_ == 2) {
    put(group_ / "memory.reclaim", std::to_string(bytes_));
    put(group_ / "memory.peak", "reset");
  }
}

LimitFigures MemoryLimit::figures() const {
  if (version_ == 1)
    return {number_in(group_ / "memory.max_usage_in_bytes"), number_in(group_ / "memory.failcnt")};
  if (version_ == 2)
    return {number_in(group_ / "memory.peak"), number_in(group_ / "memory.events", "max")};
  return {};
}

bool MemoryLimit::holds() const {
  if (!limited()) return false;
  reset_figures();
  const std::uint64_t touched = bytes_ / 4 * 5;
  bool ended = false;
  try {
    run_in_own_process(
        [&]() -> nlohmann::json {
          void* const memory =
              ::mmap(nullptr, touched, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
          if (memory == MAP_FAILED) throw system_error("allocate", "memory", errno);
          for (std::uint64_t at = 0; at < touched; at += 4096)
            static_cast<volatile char*>(memory)[at] = 1;
          return true;
        },
        this);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kOutOfMemory) throw;
    ended = true;
  }
  const LimitFigures counted = figures();
  // Where the kernel has no memory.peak, only the end of the process tells.
  return counted.peak_bytes == 0 ? ended : counted.peak_bytes <= bytes_ + 4096;
}

}  // namespace plait::instrument
