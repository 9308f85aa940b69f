// bench/backends/quick_memory.h: how much a quick comparison moves, so that its time is enough on
// these disks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace plait::bench {

/// Bytes a second of one stream, to the disk and from it.
struct DiskSpeed {
  double write = 0, read = 0;
};

/// The memory limit with which `plait bench --quick` measures on all of `disks`: the largest of 64,
/// 32 and 16 MiB with which three rounds, and the making of the stores before them, are likely to
/// take at most `seconds`. 16 MiB if none is. Pinned by QuickMemory_* in
/// tests/bench/backends/bench_test.cpp.
std::uint64_t quick_memory(std::span<const DiskSpeed> disks, double seconds);

/// Moves 32 MiB each way in each directory, in processes of their own, and removes its files.
/// Errors: kNotFound, kIo, kNoSpace.
std::vector<DiskSpeed> measure_speeds(std::span<const std::filesystem::path> directories);

}  // namespace plait::bench
