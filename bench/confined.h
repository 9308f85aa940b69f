// bench/confined.h: runs work in a child process, under a memory limit, with a cold page cache.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "instrument/memory_limit.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"

namespace plait::bench {

using instrument::MemoryLimit;
using instrument::output_of;

/// Runs `work` in a child process inside the limit and returns its figures. Errors: those of
/// run_in_own_process().
inline std::vector<double> run_for_figures(const MemoryLimit& limit,
                                           const std::function<std::vector<double>()>& work) {
  return instrument::run_in_own_process([&] { return nlohmann::json(work()); }, &limit)
      .result.get<std::vector<double>>();
}
/// The same for one figure.
inline double run_for_figure(const MemoryLimit& limit, const std::function<double()>& work) {
  return run_for_figures(limit, [&] { return std::vector<double>{work()}; }).at(0);
}

/// Writes the files to the disk and drops their pages. Returns false if pages stay.
inline bool make_cold(const std::vector<std::filesystem::path>& files) {
  return instrument::is_cold(instrument::make_cold(files));
}

}  // namespace plait::bench
