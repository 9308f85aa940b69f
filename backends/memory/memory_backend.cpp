#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <limits>

#include "built_in_backends.h"
#include "level_file.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class MemoryBackend final : public Backend {
 public:
  explicit MemoryBackend(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        mapped_bytes_(std::max(fixed_file_bytes(geometry_), kPageBytes)) {
    check_level(level, std::numeric_limits<std::uint32_t>::max());
    if (level.mode != OpenMode::kCreate)
      throw Error(ErrorCode::kBadState, "open a level in memory: expected a new one");
    void* const mapped =
        ::mmap(nullptr, mapped_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapped == MAP_FAILED) throw system_error("map", "a level in memory", errno);
    base_ = static_cast<std::byte*>(mapped);
    // With huge pages, 2 MiB cost one page fault instead of 512. If huge pages are off, the level
    // is only slower.
    ::madvise(mapped, mapped_bytes_, MADV_HUGEPAGE);
  }
  ~MemoryBackend() override { ::munmap(base_, mapped_bytes_); }
  MemoryBackend(const MemoryBackend&) = delete;
  MemoryBackend& operator=(const MemoryBackend&) = delete;

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    copy_unless_same(address(blocks.first), into.data(), into.size());
    zero_unwritten(geometry_, table_, blocks, into);
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_request(geometry_, blocks, from.size());
    copy_unless_same(from.data(), address(blocks.first), from.size());
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block)
      table_.mark_written(block, geometry_.block_offset(block), geometry_.block_bytes(block));
  }

  std::byte* address(std::uint64_t block) override { return base_ + geometry_.block_offset(block); }
  void advise(BlockRange, Advice) noexcept override {}
  void sync(bool) override {}
  std::uint64_t stored_bytes() const override { return geometry_.total_bytes(); }

 private:
  const LevelGeometry& geometry_;
  BlockTable& table_;
  std::uint64_t mapped_bytes_;
  std::byte* base_ = nullptr;
};

}  // namespace

std::unique_ptr<Backend> open_memory_backend(const LevelSpec& level) {
  return std::make_unique<MemoryBackend>(level);
}

PLAIT_END_NAMESPACE
