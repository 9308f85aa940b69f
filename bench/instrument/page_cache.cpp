#include "instrument/page_cache.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string>

#include "instrument/disk.h"
#include "plait/error.h"
#include "plait/extend/file.h"

namespace plait::instrument {

namespace fs = std::filesystem;

namespace {

Residency residency_of(const fs::path& file) {
  const File opened(file, OpenMode::kRead);
  const std::uint64_t bytes = opened.size();
  if (bytes == 0) return {};
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  void* const mapped = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, opened.descriptor(), 0);
  if (mapped == MAP_FAILED) throw system_error("map", file.native(), errno);
  std::vector<unsigned char> present((bytes + page - 1) / page);
  const int failure = ::mincore(mapped, bytes, present.data()) != 0 ? errno : 0;
  ::munmap(mapped, bytes);
  if (failure != 0) throw system_error("inspect the pages of", file.native(), failure);
  const auto pages = static_cast<std::uint64_t>(
      std::ranges::count_if(present, [](unsigned char one) { return (one & 1) != 0; }));
  return {bytes, std::min(bytes, pages * page)};
}

}  // namespace

Residency residency(const std::vector<fs::path>& files) {
  Residency sum;
  for (const fs::path& file : files) {
    const Residency one = residency_of(file);
    sum.bytes += one.bytes;
    sum.resident_bytes += one.resident_bytes;
  }
  return sum;
}

std::vector<fs::path> files_under(const fs::path& directory) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(directory))
    if (entry.is_regular_file() && !entry.is_symlink()) files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

Residency make_cold(const std::vector<fs::path>& files) {
  for (const fs::path& path : files) {
    const File file(path, OpenMode::kRead);
    if (::fdatasync(file.descriptor()) != 0) throw system_error("sync", path.native(), errno);
    ::posix_fadvise(file.descriptor(), 0, 0, POSIX_FADV_DONTNEED);
  }
  Residency left = residency(files);
  // What a file system in memory holds has no other place.
  if (is_cold(left) ||
      std::ranges::all_of(files, [](const fs::path& file) { return disk_facts(file).in_memory; }))
    return left;
  ::sync();
  std::ofstream drop("/proc/sys/vm/drop_caches");
  drop << "3" << std::flush;
  return drop.good() ? residency(files) : left;
}

}  // namespace plait::instrument
