// bench/instrument/page_cache.h: makes files cold, and proves it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace plait::instrument {

/// How much of files is in the page cache.
struct Residency {
  std::uint64_t bytes = 0, resident_bytes = 0;
  double share() const {
    return bytes == 0 ? 0 : static_cast<double>(resident_bytes) / static_cast<double>(bytes);
  }
};

/// The pages of files that memory holds (mincore), without touching them. A file on a file system
/// in memory is always resident. Errors: kIo, kNotFound.
Residency residency(const std::vector<std::filesystem::path>& files);

/// The regular files of a directory and of those in it.
std::vector<std::filesystem::path> files_under(const std::filesystem::path& directory);

/// Writes what is dirty of the files to the disk and asks the kernel to drop their pages
/// (posix_fadvise; needs no privileges and leaves other programs' pages). If pages stay, drops the
/// whole page cache where that is permitted. Returns what is still resident: cold is proved only if
/// that is next to nothing, see is_cold(). Errors: kIo, kNotFound.
Residency make_cold(const std::vector<std::filesystem::path>& files);

/// At most a hundredth of the bytes is resident.
inline bool is_cold(const Residency& residency) { return residency.share() <= 0.01; }

}  // namespace plait::instrument
