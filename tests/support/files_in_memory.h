// tests/support/files_in_memory.h: tells where the backend "auto" is another one.
#pragma once

#include <linux/magic.h>
#include <sys/vfs.h>

#include <filesystem>

namespace plait::test {

/// Whether the files of this directory are in memory (tmpfs).
inline bool keeps_files_in_memory(const std::filesystem::path& directory) {
  struct statfs status {};
  return ::statfs(directory.c_str(), &status) == 0 && status.f_type == TMPFS_MAGIC;
}

}  // namespace plait::test
