// plait/machine.h: what the machine has left, for whoever looks before a long run begins. Figures
// of a moment: others use the machine too, so that what fitted may not fit any more.
#pragma once

#include <cstdint>
#include <filesystem>

namespace plait {

/// Bytes that this process could still take without swapping: the least of what the system has
/// available (MemAvailable of /proc/meminfo), of what each memory cgroup of the process leaves,
/// its page cache not counted (versions 1 and 2), and of what RLIMIT_AS leaves. 2^64 - 1 where
/// none of them can be had. Pinned by tests/engine/io/machine_test.cpp.
std::uint64_t available_memory_bytes();

/// Bytes that may still be written to the file system of `path`, or of the nearest directory above
/// it that exists, without the privileges of root. Errors: kIo.
std::uint64_t free_disk_bytes(const std::filesystem::path& path);

/// The longest file that this process may write (RLIMIT_FSIZE); 2^64 - 1: any.
std::uint64_t largest_file_bytes();

}  // namespace plait
