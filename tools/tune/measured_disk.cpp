#include "tune/measured_disk.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "instrument/disk_floors.h"
#include "instrument/statistics.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "plait/stopwatch.h"
#include "tune/thread_time.h"

namespace plait::tune {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kPage = 4096;

/// A directory of our own, so that no file of others is touched.
class ScratchDirectory {
 public:
  explicit ScratchDirectory(const fs::path& parent) {
    std::string name = (parent / "plait-tune-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      const int number = errno;
      throw Error(
          number == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
          fmt::format("measure the disk under {}: {}", parent.native(), std::strerror(number)));
    }
    path_ = name;
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

Figure figure_of(const std::vector<double>& values) {
  const instrument::Estimate estimate = instrument::median_interval(values);
  return {estimate.value, estimate.low, estimate.high};
}

std::uint64_t number_in(const char* file) {
  std::uint64_t number = 0;
  std::ifstream(file) >> number;
  return number;
}

}  // namespace

double unwritten_bytes_limit() {
  const std::uint64_t bytes = number_in("/proc/sys/vm/dirty_background_bytes");
  if (bytes > 0) return static_cast<double>(bytes);
  const std::uint64_t percent = number_in("/proc/sys/vm/dirty_background_ratio");
  return static_cast<double>(available_memory_bytes()) * static_cast<double>(percent) / 100;
}

MeasuredDisk measure_disk(const fs::path& directory, std::uint64_t most_bytes,
                          std::uint64_t block_bytes, int threads, double seconds,
                          const std::function<bool()>& proceed) {
  constexpr int kMostRuns = 5;
  constexpr std::uint64_t kRandomReads = 64;
  const Stopwatch clock;
  const ScratchDirectory scratch(directory);
  MeasuredDisk measured;
  measured.block_bytes = block_bytes;
  // A full disk would disturb others.
  measured.bytes = std::min(most_bytes, free_disk_bytes(directory) / 4) / block_bytes * block_bytes;
  if (measured.bytes == 0)
    throw Error(ErrorCode::kNoSpace,
                fmt::format("measure the disk under {}: expected {} free bytes, found {}",
                            directory.native(), 4 * block_bytes, free_disk_bytes(directory)));
  instrument::FloorRequest request;
  request.directory = scratch.path();
  request.bytes = measured.bytes;
  request.block_bytes = block_bytes;
  request.threads = threads;
  std::vector<double> read, write, page, block;
  const auto run = [&](instrument::FloorKind kind, std::uint64_t bytes, std::uint64_t unit) {
    instrument::FloorRequest one = request;
    one.kind = kind;
    one.bytes = bytes;
    one.file_bytes = measured.bytes;
    one.block_bytes = unit;
    one.seed = static_cast<std::uint64_t>(measured.runs) + 1;
    if (kind == instrument::FloorKind::kRandomRead) one.threads = 1;
    const instrument::FloorResult result = own_floor(one);
    measured.is_cold = measured.is_cold && result.cold;
    return result.seconds;
  };
  using enum instrument::FloorKind;
  const auto bytes = static_cast<double>(measured.bytes);
  while (measured.runs < kMostRuns && (measured.runs == 0 || clock.seconds() < seconds)) {
    if (!proceed()) break;
    write.push_back(bytes / run(kWrite, measured.bytes, block_bytes));
    if (!proceed()) break;
    read.push_back(bytes / run(kRead, measured.bytes, block_bytes));
    if (!proceed()) break;
    page.push_back(run(kRandomRead, kRandomReads * kPage, kPage) / kRandomReads);
    const std::uint64_t blocks =
        std::min<std::uint64_t>(kRandomReads, measured.bytes / block_bytes);
    block.push_back(run(kRandomRead, blocks * block_bytes, block_bytes) /
                    static_cast<double>(blocks));
    ++measured.runs;
  }
  if (measured.runs == 0) throw Error(ErrorCode::kCancelled, "measure the disk: cancelled");
  measured.read = figure_of(read);
  measured.write = figure_of(write);
  // A read takes a latency and then each byte its time: a line through two points.
  const double of_page = instrument::median(page), of_block = instrument::median(block);
  const double a_byte = std::max((of_block - of_page) / static_cast<double>(block_bytes - kPage),
                                 1 / (100 * measured.read.value));
  measured.disk = {fmt::format("this disk ({})", directory.native()),
                   measured.read.value,
                   measured.write.value,
                   std::max(0.0, of_page - a_byte * static_cast<double>(kPage)),
                   1 / a_byte,
                   unwritten_bytes_limit(),
                   true};
  return measured;
}

double processors_for(int threads, const std::function<void()>& work) {
  constexpr int kCalls = 4;
  work();
  const double start = thread_seconds();
  for (int i = 0; i < kCalls; ++i) work();
  const double alone = (thread_seconds() - start) / kCalls;
  const Stopwatch clock;
  {
    std::vector<std::jthread> others;
    others.reserve(static_cast<std::size_t>(threads));
    for (int i = 0; i < threads; ++i)
      others.emplace_back([&] {
        for (int call = 0; call < kCalls; ++call) work();
      });
  }
  const double together = clock.seconds();
  return std::clamp(alone * kCalls * threads / together, 0.05, static_cast<double>(threads));
}

}  // namespace plait::tune
