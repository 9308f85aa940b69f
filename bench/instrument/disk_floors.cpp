#include "instrument/disk_floors.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/align/aligned_allocator.hpp>
#include <cstddef>
#include <random>
#include <span>
#include <vector>

#include "base/stopwatch.h"
#include "instrument/in_threads.h"
#include "instrument/page_cache.h"
#include "instrument/process.h"
#include "plait/error.h"
#include "plait/extend/file.h"

namespace plait::instrument {
namespace {

namespace fs = std::filesystem;

using AlignedBytes = std::vector<std::byte, boost::alignment::aligned_allocator<std::byte, 4096>>;

/// Bytes that no file system or disk compresses away.
AlignedBytes filled(std::uint64_t bytes, std::uint64_t seed) {
  AlignedBytes memory(bytes);
  std::mt19937_64 random(seed);
  for (std::byte& byte : memory) byte = static_cast<std::byte>(random() >> 56);
  return memory;
}

/// Whole blocks, and at least one.
std::uint64_t rounded_up(std::uint64_t bytes, const FloorRequest& request) {
  const std::uint64_t blocks = (bytes + request.block_bytes - 1) / request.block_bytes;
  return std::max<std::uint64_t>(blocks, 1) * request.block_bytes;
}
std::uint64_t moved_bytes(const FloorRequest& request) {
  return rounded_up(request.bytes, request);
}
std::uint64_t file_bytes(const FloorRequest& request) {
  return rounded_up(request.file_bytes == 0 ? request.bytes : request.file_bytes, request);
}

fs::path read_file(const FloorRequest& request) { return request.directory / "plait-bench.floor"; }
fs::path written_file(const FloorRequest& request) {
  return request.directory / "plait-bench.floor.new";
}

void check(const FloorRequest& request) {
  if (request.block_bytes == 0 || request.block_bytes % 4096 != 0 || request.threads < 1)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("measure a floor: expected blocks of whole pages of 4096 bytes and at "
                            "least one thread, found {} bytes and {} threads",
                            request.block_bytes, request.threads));
}

bool makes_file(const FloorRequest& request) { return request.kind == FloorKind::kWrite; }

bool writes(FloorKind kind) { return kind == FloorKind::kWrite || kind == FloorKind::kUpdate; }

/// Moves the blocks of one thread: every `threads`-th one, so that all threads stay close together.
void move_share(const FloorRequest& request, File& file, std::size_t thread,
                std::span<std::byte> memory) {
  const std::uint64_t blocks = moved_bytes(request) / request.block_bytes;
  const std::uint64_t in_file = file_bytes(request) / request.block_bytes;
  std::mt19937_64 random(1000 + thread);
  for (std::uint64_t block = thread; block < blocks;
       block += static_cast<std::uint64_t>(request.threads)) {
    const std::uint64_t at =
        request.kind == FloorKind::kRandomRead ? random() % in_file : block % in_file;
    if (!makes_file(request)) file.read_at(at * request.block_bytes, memory);
    if (writes(request.kind)) file.write_at(at * request.block_bytes, memory);
  }
}

/// The file that a floor moves: absent if the floor makes it, else there and cold.
fs::path make_ready(const FloorRequest& request, FloorResult& result) {
  fs::path path = makes_file(request) ? written_file(request) : read_file(request);
  if (makes_file(request)) {
    fs::remove(path);
    return path;
  }
  if (!fs::exists(path) || fs::file_size(path) < file_bytes(request)) prepare_floor_file(request);
  result.cold = is_cold(make_cold({path})) || request.direct;
  return path;
}

}  // namespace

std::string_view to_string(FloorKind kind) noexcept {
  constexpr std::string_view kNames[] = {"write", "read", "random-read", "update"};
  return kNames[static_cast<std::size_t>(kind)];
}

void prepare_floor_file(const FloorRequest& request) {
  check(request);
  fs::remove(read_file(request));
  File file(read_file(request), OpenMode::kCreate);
  const std::uint64_t bytes = file_bytes(request);
  file.preallocate(bytes);
  const AlignedBytes memory = filled(request.block_bytes, 7);
  for (std::uint64_t at = 0; at < bytes; at += request.block_bytes) file.write_at(at, memory);
  file.sync();
  file.close();
}

void remove_floor_files(const fs::path& directory) noexcept {
  std::error_code ignored;
  fs::remove(directory / "plait-bench.floor", ignored);
  fs::remove(directory / "plait-bench.floor.new", ignored);
}

FloorResult own_floor(const FloorRequest& request) {
  check(request);
  const bool fresh = makes_file(request);
  FloorResult result;
  const fs::path path = make_ready(request, result);
  std::vector<AlignedBytes> memory;
  memory.reserve(static_cast<std::size_t>(request.threads));
  for (int thread = 0; thread < request.threads; ++thread)
    memory.push_back(filled(request.block_bytes, static_cast<std::uint64_t>(thread)));
  const Stopwatch clock;
  {
    File file(path,
              fresh                  ? OpenMode::kCreate
              : writes(request.kind) ? OpenMode::kReadWrite
                                     : OpenMode::kRead,
              request.direct ? Caching::kNone : Caching::kPageCache);
    if (fresh && request.direct) file.preallocate(moved_bytes(request));
    in_threads(request.threads,
               [&](std::size_t thread) { move_share(request, file, thread, memory[thread]); });
    if (writes(request.kind)) file.sync();
    file.close();
  }
  result.seconds = clock.seconds();
  result.bytes_read = fresh ? 0 : moved_bytes(request);
  result.bytes_written = writes(request.kind) ? moved_bytes(request) : 0;
  result.method =
      fmt::format("{}{}{}{}{}", request.direct ? "O_DIRECT " : "",
                  fresh                                ? "pwrite"
                  : request.kind == FloorKind::kUpdate ? "pread + pwrite"
                                                       : "pread",
                  writes(request.kind) ? " + fdatasync" : "",
                  request.threads > 1 ? fmt::format(", {} threads", request.threads) : "",
                  result.cold ? "" : ", WARM");
  if (fresh) fs::remove(path);
  return result;
}

bool have_fio() {
  static const bool have = !output_of("fio --version 2>/dev/null").empty();
  return have;
}

std::optional<FloorResult> fio_floor(const FloorRequest& request) {
  check(request);
  // fio cannot read a block and write the same one back, so an update has no partner.
  if (!have_fio() || request.kind == FloorKind::kUpdate) return {};
  // The name of the file is in a shell command, and ':' separates files in fio.
  if (request.directory.native().find_first_of("'\\:") != std::string::npos) return {};
  const bool fresh = makes_file(request);
  FloorResult result;
  const fs::path path = make_ready(request, result);
  const auto threads = static_cast<std::uint64_t>(request.threads);
  const std::uint64_t share =
      std::max<std::uint64_t>(moved_bytes(request) / request.block_bytes / threads, 1) *
      request.block_bytes;
  // As own_floor(): each thread has every threads-th block and one in flight, without advice to the
  // kernel, and space is reserved where own_floor() does so.
  const std::uint64_t skip = (threads - 1) * request.block_bytes;
  const std::string pattern =
      request.kind == FloorKind::kRandomRead
          ? fmt::format("--rw=randread --norandommap --randrepeat=1 --size={} --readonly",
                        file_bytes(request))
          : fmt::format("--rw={}{} --offset_increment={} --size={}", fresh ? "write" : "read",
                        skip > 0 ? fmt::format(":{}", skip) : "", request.block_bytes,
                        share * threads - skip);
  const std::string command = fmt::format(
      "fio --name=floor '--filename={}' {} --bs={} --ioengine=psync --direct={} --thread "
      "--numjobs={} --group_reporting --io_size={} --fadvise_hint=0 --fallocate={} {} "
      "--output-format=json 2>/dev/null",
      path.native(), pattern, request.block_bytes, request.direct ? 1 : 0, threads, share,
      fresh && request.direct ? "native" : "none", fresh ? "--end_fsync=1" : "");
  const std::string text = output_of(command);
  if (fresh) fs::remove(path);
  const std::size_t start = text.find('{');
  if (start == std::string::npos) return {};
  const nlohmann::json report = nlohmann::json::parse(text.substr(start), nullptr, false);
  if (!report.is_object() || !report.contains("jobs") || report["jobs"].empty()) return {};
  const nlohmann::json& job = report["jobs"][0];
  result.bytes_read = job["read"]["io_bytes"].get<std::uint64_t>();
  result.bytes_written = job["write"]["io_bytes"].get<std::uint64_t>();
  // job_runtime adds up the threads, and counts the fsync at the end.
  result.seconds = job["job_runtime"].get<double>() / 1000 / static_cast<double>(threads);
  if (result.seconds <= 0 || result.bytes_read + result.bytes_written == 0) return {};
  result.method = fmt::format("fio psync{}", request.direct ? " O_DIRECT" : "");
  return result;
}

}  // namespace plait::instrument
