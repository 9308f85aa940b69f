// bench/instrument/disk_floors.h: how long a disk takes to move bytes for a plain program that
// computes nothing. A figure of a backend means something only beside its floor: same bytes, block
// size, caching and durability, in the same minute.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace plait::instrument {

enum class FloorKind : std::uint8_t {
  kWrite,       ///< a new file, front to back, preallocated if direct
  kRead,        ///< an existing file, front to back, cold
  kRandomRead,  ///< whole blocks of an existing file, each position drawn anew
  kUpdate,      ///< an existing file: read a block, write it back, front to back
};
std::string_view to_string(FloorKind kind) noexcept;

/// What a floor moves. Files lie in `directory` and are removed by remove_floor_files().
struct FloorRequest {
  std::filesystem::path directory;
  FloorKind kind = FloorKind::kWrite;
  std::uint64_t bytes = 0;              ///< that the work needs; kUpdate reads and writes as many
  std::uint64_t file_bytes = 0;         ///< of kRandomRead: the file to draw from; 0: `bytes`
  std::uint64_t block_bytes = 1 << 20;  ///< a multiple of 4096
  bool direct = false;                  ///< past the page cache (O_DIRECT)
  int threads = 1;                      ///< each moves its share with one block in flight
};

struct FloorResult {
  double seconds = 0;
  std::uint64_t bytes_read = 0, bytes_written = 0;
  std::string method;  ///< "pwrite + fdatasync", "fio psync"
  bool cold = true;    ///< proved by mincore before a read; also true where direct
  /// Both directions together.
  double bytes_per_second() const {
    return static_cast<double>(bytes_read + bytes_written) / seconds;
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FloorResult, seconds, bytes_read, bytes_written, method, cold)

/// Makes or renews the file that kRead, kRandomRead and kUpdate read; costs its bytes once.
/// Errors: kIo, kNoSpace.
void prepare_floor_file(const FloorRequest& request);
void remove_floor_files(const std::filesystem::path& directory) noexcept;

/// By this program's own loop. Makes the file if it is missing, and cold if the kind reads. Errors:
/// kIo, kNoSpace; kNotSupported without O_DIRECT; kInvalidArgument.
FloorResult own_floor(const FloorRequest& request);

bool have_fio();
/// The same by fio, with the same pattern, queue depth and flags; nothing where it has no such
/// pattern (kUpdate), is not installed, or fails.
std::optional<FloorResult> fio_floor(const FloorRequest& request);

}  // namespace plait::instrument
