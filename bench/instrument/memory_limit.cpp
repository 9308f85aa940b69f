#include "instrument/memory_limit.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string_view>
#include <system_error>
#include <thread>

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

constexpr std::string_view kGroupPrefix = "plait-bench-";

/// Groups have no name in common, also if a process makes several.
fs::path new_name() {
  static int made = 0;
  return fmt::format("{}{}-{}", kGroupPrefix, ::getpid(), ++made);
}

/// Locks the directory, so that no other process takes a group between its making and its lock.
/// Does without after a second, because other programs may lock it too. Errors: kIo.
Directory hold(const fs::path& parent) {
  Directory held(parent);
  for (int waited = 0; waited < 1000 && !held.lock(true); ++waited)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return held;
}

/// The kernel removes no group with a process in it, so a group without a lock is dead.
bool is_dead(const Directory& parent, const std::string& name) {
  try {
    return Directory(parent, name).lock(true);
  } catch (const Error&) {  // it is gone
    return false;
  }
}

}  // namespace

MemoryLimit::Places MemoryLimit::Places::of_this_machine() {
  const std::string mount = "/sys/fs/cgroup";
  Places places;
  if (std::error_code failed; !fs::exists(mount + "/cgroup.controllers", failed)) return places;
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);)
    if (line.starts_with("0::")) {
      // A group with processes cannot give its children a controller, so the groups above it are
      // tried too.
      fs::path own = fs::path(mount + line.substr(3)).lexically_normal();
      for (; own.native().size() >= mount.size(); own = own.parent_path()) places.v2.push_back(own);
    }
  return places;
}

std::vector<fs::path> MemoryLimit::dead_groups(bool remove, const Places& places) {
  std::vector<fs::path> parents = places.v2;
  parents.push_back(places.v1);
  std::vector<fs::path> dead;
  for (const fs::path& parent : parents) {
    try {
      const Directory held = hold(parent);
      for (const std::string& name : held.names())
        if (name.starts_with(kGroupPrefix) && is_dead(held, name) &&
            (!remove || ::rmdir(held.path_of(name).c_str()) == 0))
          dead.push_back(held.path_of(name));
    } catch (const Error&) {  // it is not ours to open
      continue;
    }
  }
  return dead;
}

MemoryLimit::MemoryLimit(std::uint64_t bytes, const Places& places) : bytes_(bytes) {
  dead_groups(true, places);
  std::error_code failed;
  const auto try_group = [&](const fs::path& parent, const char* file, int version) {
    const fs::path group = parent / new_name();
    try {
      const Directory held = hold(parent);
      if (!fs::create_directory(group, failed)) return false;
      lock_ = Directory(group);
      if (lock_.lock(true) && put(group / file, std::to_string(bytes))) {
        group_ = group;
        version_ = version;
        return true;
      }
    } catch (const Error&) {  // the next place is tried
    }
    ::rmdir(group.c_str());
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
  if (!limited()) return {};
  const bool first = version_ == 1;
  const auto peak = number_in(group_ / (first ? "memory.max_usage_in_bytes" : "memory.peak"));
  const auto full =
      first ? number_in(group_ / "memory.failcnt") : number_in(group_ / "memory.events", "max");
  return {peak.value_or(0), full.value_or(0)};
}

bool MemoryLimit::holds() const {
  if (!limited()) return false;
  reset_figures();
  const std::uint64_t touched = bytes_ / 4 * 5;
  bool ended = false;
  try {
    run_in_own_process(
        [&]() -> nlohmann::json {
          const auto memory = std::make_unique_for_overwrite<char[]>(touched);
          volatile char* const touch = memory.get();
          for (std::uint64_t at = 0; at < touched; at += 4096) touch[at] = 1;
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
