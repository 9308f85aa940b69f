#include "backends/quick_memory.h"

#include <algorithm>
#include <array>

#include "instrument/disk_floors.h"
#include "instrument/process.h"
#include "instrument/scratch_directory.h"

namespace plait::bench {
namespace {

using instrument::FloorKind;

constexpr int kRounds = 3;
constexpr std::array<std::uint64_t, 3> kMemory = {64u << 20, 32u << 20, 16u << 20};
constexpr std::uint64_t kProbeBytes = 32u << 20;

/// What a quick comparison moves, in bytes of the levels: three raw backends and two presets build,
/// sweep and read patches, and floors move the same. The presets store about half and a third of
/// the bytes.
constexpr double kLevelsOverMemory = 2;
constexpr double kWrittenBefore = 6, kWrittenInRound = 6, kReadInRound = 16;
/// A round computes so long for a byte of the levels on one disk, mostly in the codecs. The rest of
/// its 15 runs takes so long whatever is moved, because each run lasts 0.3 s at least.
constexpr double kSecondsPerByte = 4e-8, kSecondsOfRuns = 7.5;

double seconds_with(std::uint64_t memory, std::span<const DiskSpeed> disks) {
  const double levels = kLevelsOverMemory * static_cast<double>(memory);
  double seconds = 0;
  for (const DiskSpeed& disk : disks) {
    const double computing = levels * kSecondsPerByte;
    const double round = levels * (kWrittenInRound / disk.write + kReadInRound / disk.read) +
                         computing + kSecondsOfRuns;
    seconds += levels * kWrittenBefore / disk.write + computing + kRounds * round;
  }
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
