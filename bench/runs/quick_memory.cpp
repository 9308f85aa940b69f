#include <algorithm>
#include <array>

#include "instrument/disk_floors.h"
#include "instrument/process.h"
#include "instrument/scratch_directory.h"
#include "runs/plan.h"

namespace plait::bench {
namespace {

using instrument::FloorKind;

constexpr std::array<std::uint64_t, 3> kMemory = {64u << 20, 32u << 20, 16u << 20};
constexpr std::uint64_t kProbeBytes = 32u << 20;

/// What a quick comparison moves on a disk, in bytes of the levels: three raw backends and two
/// presets are stored once, and in each of four rounds they build, sweep and read patches, and
/// floors move the same. The presets store about half and a third of the bytes. What is three times
/// slower leaves after two rounds, so that the third and the fourth take about half as much.
constexpr double kRounds = 2 + 2 * 0.5;
constexpr double kLevelsOverMemory = 2, kWritten = 6 + kRounds * 6, kRead = kRounds * 16;
/// How long the stores and each round compute for a byte of the levels, mostly in the codecs, and
/// how long the rest of the 15 runs of a round takes whatever is moved: each lasts 0.3 s at least.
constexpr double kSecondsPerByte = (1 + kRounds) * 4e-8, kSecondsOfRuns = kRounds * 7.5;

double seconds_with(std::uint64_t memory, std::span<const DiskSpeed> disks) {
  const double levels = kLevelsOverMemory * static_cast<double>(memory);
  double seconds = 0;
  for (const DiskSpeed& disk : disks)
    seconds +=
        levels * (kWritten / disk.write + kRead / disk.read + kSecondsPerByte) + kSecondsOfRuns;
  return seconds;
}

}  // namespace

std::uint64_t quick_memory(std::span<const DiskSpeed> disks, double seconds) {
  const auto fits = [&](std::uint64_t memory) { return seconds_with(memory, disks) <= seconds; };
  const auto found = std::ranges::find_if(kMemory, fits);
  return found == kMemory.end() ? kMemory.back() : *found;
}

std::vector<DiskSpeed> measure_speeds(std::span<const std::filesystem::path> directories) {
  std::vector<DiskSpeed> speeds;
  for (const std::filesystem::path& directory : directories) {
    const instrument::ScratchDirectory scratch(directory);
    const auto speed = [&](FloorKind kind) {
      const instrument::FloorRequest request{
          .directory = scratch.path(), .kind = kind, .bytes = kProbeBytes};
      return instrument::in_own_process(
                 [&]() -> nlohmann::json { return own_floor(request).bytes_per_second(); })
          .get<double>();
    };
    const double write = speed(FloorKind::kWrite);
    speeds.push_back({write, speed(FloorKind::kRead)});
  }
  return speeds;
}

}  // namespace plait::bench
