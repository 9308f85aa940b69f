#include "tune/measured_disk.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <thread>
#include <vector>

#include "instrument/disk_floors.h"
#include "instrument/statistics.h"
#include "plait/error.h"
#include "plait/machine.h"
#include "plait/stopwatch.h"
#include "tune/scratch_directory.h"
#include "tune/thread_time.h"

namespace plait::tune {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kPage = 4096;

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
                          const std::vector<std::uint64_t>& block_sizes, int threads,
                          double seconds, const std::function<bool()>& proceed) {
  constexpr int kMostRuns = 5;
  constexpr std::uint64_t kRandomReads = 64;
  const Stopwatch clock;
  const ScratchDirectory scratch(directory, "plait-tune");
  MeasuredDisk measured;
  const std::uint64_t largest = block_sizes.back();
  // A full disk would disturb others.
  measured.bytes = std::min(most_bytes, free_disk_bytes(directory) / 4) / largest * largest;
  if (measured.bytes == 0)
    throw Error(ErrorCode::kNoSpace,
                fmt::format("measure the disk under {}: expected {} free bytes, found {}",
                            directory.native(), 4 * largest, free_disk_bytes(directory)));
  const auto run = [&](instrument::FloorKind kind, std::uint64_t bytes, std::uint64_t unit) {
    instrument::FloorRequest one;
    one.directory = scratch.path();
    one.kind = kind;
    one.bytes = bytes;
    one.file_bytes = measured.bytes;
    one.block_bytes = unit;
    one.seed = static_cast<std::uint64_t>(measured.runs) + 1;
    one.threads = kind == instrument::FloorKind::kRandomRead ? 1 : threads;
    instrument::FloorResult result = own_floor(one);
    measured.is_cold = measured.is_cold && result.cold;
    return result;
  };
  using enum instrument::FloorKind;
  const auto bytes = static_cast<double>(measured.bytes);
  std::vector<double> sixteenth;
  std::vector<std::vector<double>> first_half(block_sizes.size()), second_half(block_sizes.size()),
      write(block_sizes.size());
  std::vector<double> page, block;
  const std::uint64_t blocks = std::min<std::uint64_t>(kRandomReads, measured.bytes / largest);
  const auto one_round = [&] {
    for (std::size_t i = 0; i < block_sizes.size(); ++i) {
      if (!proceed()) return false;
      write[i].push_back(bytes / run(kWrite, measured.bytes, block_sizes[i]).seconds);
      if (!proceed()) return false;
      const instrument::FloorResult read = run(kRead, measured.bytes, block_sizes[i]);
      if (i + 1 == block_sizes.size()) sixteenth.push_back(read.first_sixteenth_seconds);
      first_half[i].push_back(read.first_half_seconds);
      second_half[i].push_back(read.seconds - read.first_half_seconds);
    }
    if (!proceed()) return false;
    page.push_back(run(kRandomRead, kRandomReads * kPage, kPage).seconds / kRandomReads);
    block.push_back(run(kRandomRead, blocks * largest, largest).seconds /
                    static_cast<double>(blocks));
    return true;
  };
  while (measured.runs < kMostRuns && (measured.runs == 0 || clock.seconds() < seconds)) {
    if (!one_round()) break;
    ++measured.runs;
  }
  if (measured.runs == 0) throw Error(ErrorCode::kCancelled, "measure the disk: cancelled");
  // A thread notes the time before one of its blocks, so of few blocks there are no halves.
  constexpr std::uint64_t kFewestBlocks = 32;
  const Burst burst =
      measured.bytes / largest < kFewestBlocks
          ? Burst()
          : burst_of(bytes, instrument::median(sixteenth), instrument::median(first_half.back()),
                     instrument::median(second_half.back()));
  measured.disk.burst_bytes = burst.bytes;
  measured.disk.burst_read = burst.rate;
  for (std::size_t i = 0; i < block_sizes.size(); ++i) {
    std::vector<double> read;
    for (std::size_t turn = 0; turn < first_half[i].size(); ++turn)
      read.push_back(burst.bytes > 0 ? bytes / 2 / second_half[i][turn]
                                     : bytes / (first_half[i][turn] + second_half[i][turn]));
    const BlockFloor floor{block_sizes[i], figure_of(read), figure_of(write[i])};
    measured.floors.push_back(floor);
    measured.disk.of_blocks.push_back(
        {static_cast<double>(floor.block_bytes), floor.read.value, floor.write.value});
  }
  // A read takes a latency and then each byte its time: a line through two points.
  const double of_page = instrument::median(page), of_block = instrument::median(block);
  Disk& disk = measured.disk;
  disk.name = fmt::format("this disk ({})", directory.native());
  disk.read = measured.floors.back().read.value;
  disk.write = measured.floors.back().write.value;
  const double a_byte =
      std::max((of_block - of_page) / static_cast<double>(largest - kPage), 1 / (100 * disk.read));
  disk.latency = std::max(0.0, of_page - a_byte * static_cast<double>(kPage));
  disk.random_read = 1 / a_byte;
  disk.unwritten_bytes = unwritten_bytes_limit();
  disk.is_measured = true;
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
