// The rate at which the disk reads random blocks of a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace plait::bench {

struct RandomReads {
  std::filesystem::path file;
  std::uint64_t block_bytes = 0;  ///< a multiple of 4096
  int jobs = 1;                   ///< threads
  int depth = 1;                  ///< blocks in flight of each job
  std::string engine = "psync";   ///< of fio: "psync" (depth 1), or "io_uring"
  bool direct = true;             ///< past the page cache (O_DIRECT)
};

bool have_fio();
/// Bytes a second that fio reads: past the page cache in about a second; through the page cache,
/// each block once, so that none is there already if the page cache was cold. If fio is not
/// installed, jobs * depth threads of this program read in the same way, but may read blocks
/// several times. REQUIRES: the file has at least one block for each job. Errors: kIo;
/// kNotSupported without O_DIRECT.
double bytes_per_second(const RandomReads& reads);

}  // namespace plait::bench
