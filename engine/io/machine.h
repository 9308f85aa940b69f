// io/machine.h: the current directory, free memory and free disk space of the machine, to check
// before a long run begins. Other processes use the machine too, so each figure may be out of date
// a moment later.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// The path from the root. Errors: kNotFound for a relative path if the current directory has been
/// removed.
std::filesystem::path absolute_path(const std::filesystem::path& path);

/// Bytes that this process can still allocate without swapping. This is the minimum of three
/// figures: the available memory of the system (MemAvailable in /proc/meminfo), the free memory in
/// each memory cgroup of the process (version 1 or 2, page cache counted as free), and the rest of
/// RLIMIT_AS. 2^64 - 1 if none of the three is known. Pinned by tests/engine/io/machine_test.cpp.
std::uint64_t available_memory_bytes();

/// Free bytes that a process without root privileges may use on the file system of `path`. If
/// `path` does not exist, the nearest existing directory above it counts. Errors: kIo.
std::uint64_t free_disk_bytes(const std::filesystem::path& path);

/// The size in bytes of the largest file that this process may write (RLIMIT_FSIZE). 2^64 - 1 means
/// no limit.
std::uint64_t largest_file_bytes();

PLAIT_END_NAMESPACE
