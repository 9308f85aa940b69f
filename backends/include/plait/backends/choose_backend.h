// plait/backends/choose_backend.h: chooses a raw backend for a new store, when the user names none.
// All raw backends write the same files, byte for byte. The choice decides only how fast the files
// are written and read.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/backend.h"
#include "plait/backend_choice.h"
#include "plait/machine.h"
#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A store is large if its raw bytes are more than 1/kLargeStoreDivisor of the available memory.
/// Once dirty pages fill about a tenth of the memory, Linux slows writers down to the speed of the
/// disk (vm.dirty_ratio, vm.dirty_background_ratio). Also, adding new pages to the page cache takes
/// more time than writing without the page cache. docs/backends.md has the measurement.
inline constexpr std::uint64_t kLargeStoreDivisor = 16;

/// Returns "uring" for a large store, if the kernel allows io_uring and the file system of `path`
/// has O_DIRECT; otherwise "pread". `path` need not exist, but its directory must. Never fails: if
/// a check is impossible, the choice is "pread".
/// Pinned by tests/backends/choose_backend_test.cpp.
BackendChoice choose_backend(const BackendRegistry& backends, const std::filesystem::path& path,
                             std::uint64_t raw_bytes,
                             std::uint64_t available_bytes = available_memory_bytes());

PLAIT_END_NAMESPACE
