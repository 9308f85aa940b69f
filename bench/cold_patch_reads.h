// Reads of random patches of a store four times larger than memory, compared with fio's random
// reads of as large blocks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace plait::bench {

struct ColdSettings {
  int level = 5, refinements = 7, runs = 5, reads = 4000;
  std::vector<int> threads = {1, 2, 8};
  std::vector<std::string> backends = {"pread", "uring"};
  std::uint64_t block_kibibytes = 1024;
  std::uint64_t budget_mebibytes = 0;  ///< 0: five eighths of the memory limit
  int io_threads = -1;                 ///< -1: the store's default
  std::string directory = ".", json;
};

/// Measures, and prints a Markdown table. Returns the exit status. Errors: those of the store.
int run_cold(const ColdSettings& settings);

}  // namespace plait::bench
