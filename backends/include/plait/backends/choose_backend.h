// plait/backends/choose_backend.h: which of the raw backends suits a new store where nobody said.
// Their files are the same, byte for byte: the choice decides how fast they are written and read.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/backend.h"
#include "plait/backend_choice.h"
#include "plait/machine.h"

namespace plait {

/// A store is large where its raw bytes are more than this share of the memory available. Beyond
/// about a tenth the system holds up those who write faster than the disk takes (vm.dirty_ratio,
/// vm.dirty_background_ratio), and fresh page-cache pages cost more than writing past them;
/// docs/backends.md has the measurement.
inline constexpr std::uint64_t kLargeStoreDivisor = 16;

/// "uring" for a large store where the kernel allows io_uring and the file system of `path` takes
/// O_DIRECT; else "pread". `path` need not exist, the directory that it is in does.
/// Never fails: what cannot be found out is a reason for "pread".
/// Pinned by tests/backends/choose_backend_test.cpp.
BackendChoice choose_backend(const BackendRegistry& backends, const std::filesystem::path& path,
                             std::uint64_t raw_bytes,
                             std::uint64_t available_bytes = available_memory_bytes());

}  // namespace plait
