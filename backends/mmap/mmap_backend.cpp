#include "mmap/mmap_backend.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <boost/interprocess/exceptions.hpp>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>

#include "level_file.h"
#include "plait/error.h"
#include "plait/file_operations.h"

namespace plait {
namespace {

namespace interprocess = boost::interprocess;

interprocess::mapped_region map_file(File& file, const LevelSpec& level, std::uint64_t bytes) {
  if (bytes == 0) return {};
  const FileOperation mapping{FileOperation::Kind::kMap, file.path()};
  try {
    if (const int error = before_operation(mapping).error; error != 0)
      throw system_error("map", file.path().native(), error);
    // A hole that the disk has no room for would end the process when it is stored into.
    if (level.mode == OpenMode::kReadWrite) file.preallocate(bytes);
    const auto access =
        level.mode == OpenMode::kRead ? interprocess::read_only : interprocess::read_write;
    // Boost opens by path: this is the file that is open, whatever has its name by now. The region
    // outlives its file_mapping, which only holds a descriptor.
    const std::string path = fmt::format("/proc/self/fd/{}", file.descriptor());
    return {interprocess::file_mapping(path.c_str(), access), access, 0, bytes};
  } catch (const interprocess::interprocess_exception& failure) {
    if (level.mode == OpenMode::kCreate) level.directory.remove_if_possible(level.name);
    throw Error(ErrorCode::kIo,
                fmt::format("map {}: {} bytes: {}", file.path().native(), bytes, failure.what()));
  }
}

class MmapBackend final : public Backend {
 public:
  explicit MmapBackend(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        file_(open_fixed_file(level)),
        region_(map_file(file_, level, fixed_file_bytes(geometry_))) {}

  BackendTraits traits() const noexcept override { return kMmapTraits; }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    copy_unless_same(address(blocks.first, false), into.data(), into.size());
    check_raw(geometry_, table_, blocks, into, file_.path());
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    copy_unless_same(from.data(), address(blocks.first, true), from.size());
    seal_raw(geometry_, table_, blocks, from);
    // Stores into the mapping are the system's already.
    start_writing(file_, fixed_bytes(geometry_, blocks));
  }

  std::byte* address(std::uint64_t block, bool) override {
    // Beyond the end of its file a mapping ends the process that touches it.
    if (const std::uint64_t found = file_.size(); found < fixed_file_bytes(geometry_))
      throw Error(ErrorCode::kCorruption,
                  fmt::format("access {}: expected {} bytes, found {}: it was cut short",
                              file_.path().native(), fixed_file_bytes(geometry_), found));
    return static_cast<std::byte*>(region_.get_address()) + geometry_.block_offset(block);
  }

  void advise(BlockRange blocks, Advice advice) noexcept override {
    const ByteRange bytes = fixed_bytes(geometry_, blocks);
    std::uint64_t first = bytes.first / kPageBytes * kPageBytes;
    std::uint64_t end = bytes.first + bytes.count;
    int value = MADV_NORMAL;
    switch (advice) {
      case Advice::kWillNeed:
        value = MADV_WILLNEED;
        break;
      case Advice::kSequential:
        // MADV_SEQUENTIAL makes a sweep under a memory limit two to four times slower, as
        // MADV_WILLNEED does (plait_bench_sweep_rmw).
        break;
      case Advice::kRandom:
        value = MADV_RANDOM;
        break;
      case Advice::kDontNeed:
        // Cannot lose data: the pages of a shared file mapping stay in the page cache, dirty or
        // not. Only whole pages, because the neighbouring block may still be in use.
        value = MADV_DONTNEED;
        first = (bytes.first + kPageBytes - 1) / kPageBytes * kPageBytes;
        end = end / kPageBytes * kPageBytes;
        break;
    }
    if (first < end)
      ::madvise(static_cast<std::byte*>(region_.get_address()) + first, end - first, value);
  }

  void sync(bool durable) override {
    if (!durable || mode_ == OpenMode::kRead || region_.get_size() == 0) return;
    // On Linux this is what msync(MS_SYNC) of the whole mapping does.
    file_.sync();
  }

  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  File file_;
  interprocess::mapped_region region_;
};

}  // namespace

std::unique_ptr<Backend> open_mmap_backend(const LevelSpec& level) {
  return std::make_unique<MmapBackend>(level);
}

}  // namespace plait
