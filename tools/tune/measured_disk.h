// tools/tune/measured_disk.h: measures the disk under a directory, and how many processors the
// threads of a store get on this machine, now.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "tune/disk_model.h"
#include "tune/figures.h"

namespace plait::tune {

/// What the disk does in blocks of one size, in bytes a second.
struct BlockFloor {
  std::uint64_t block_bytes = 0;
  Figure read, write;
};

struct MeasuredDisk {
  Disk disk;                       ///< the medians
  std::vector<BlockFloor> floors;  ///< of each size of blocks, ascending
  std::uint64_t bytes = 0;         ///< that each run moved
  bool is_cold = true;             ///< false on a file system in memory
  int runs = 0;
};

/// In blocks of each of `block_sizes` (ascending), writes a file of up to `most_bytes` under
/// `directory`, durably, and reads it front to back, cold; also reads single pages and blocks of
/// the largest size at random places. Runs are repeated until `seconds` have passed, at least once,
/// five times at most. The files are in a directory of their own and are removed. `threads`: that a
/// store reads and writes with. Errors: kNotFound, kIo, kNoSpace; kCancelled if `proceed` returns
/// false before the first run has ended.
MeasuredDisk measure_disk(const std::filesystem::path& directory, std::uint64_t most_bytes,
                          const std::vector<std::uint64_t>& block_sizes, int threads,
                          double seconds, const std::function<bool()>& proceed);

/// The bytes that the system holds in memory before it begins to write them to a disk
/// (vm.dirty_background_bytes, or vm.dirty_background_ratio of the available memory).
double unwritten_bytes_limit();

/// How many times as much `threads` threads get done as one thread does in its own processor time:
/// `work` calls for each thread. The result is at most `threads`, and less if other programs use
/// the processors.
double processors_for(int threads, const std::function<void()>& work);

}  // namespace plait::tune
