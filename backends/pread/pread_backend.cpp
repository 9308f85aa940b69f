#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "built_in_backends.h"
#include "level_file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class PreadBackend final : public Backend {
 public:
  explicit PreadBackend(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        file_(open_fixed_file(level)),
        in_file_(level.table.size()) {
    // A new generation has a new file and the table of the version before.
    if (mode_ != OpenMode::kCreate)
      for (std::uint64_t block = 0; block < in_file_.size(); ++block)
        in_file_[block] = is_written(block);
  }

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    // One call reads all blocks. Never-written blocks are holes in the file, which cost no disk
    // access.
    for (std::uint64_t block = blocks.first; block < blocks.first + blocks.count; ++block)
      if (is_written(block)) {
        file_.read_at(geometry_.block_offset(blocks.first), into);
        break;
      }
    check_raw(geometry_, table_, blocks, into, file_.path());
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    file_.write_at(geometry_.block_offset(blocks.first), from);
    // A new block does not change again soon, so the disk can write it while the caller computes,
    // and not only when the caller syncs. For blocks that a sweep reads and overwrites, it is
    // faster to let the system choose the time (docs/benchmarks.md).
    const std::span<std::uint8_t> in_file = std::span(in_file_).subspan(blocks.first, blocks.count);
    if (std::ranges::find(in_file, std::uint8_t{1}) == in_file.end())
      start_writing(file_, fixed_bytes(geometry_, blocks));
    std::ranges::fill(in_file, std::uint8_t{1});
    seal_raw(geometry_, table_, blocks, from);
  }

  void advise(BlockRange, Advice advice) noexcept override {
    if (advice == Advice::kSequential) advise_sequential(file_);
  }

  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  bool is_written(std::uint64_t block) const {
    return table_[block].encoding != BlockEncoding::kNeverWritten;
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  File file_;
  std::vector<std::uint8_t> in_file_;  ///< [block] not 0: the file has the block
};

}  // namespace

std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level) {
  return std::make_unique<PreadBackend>(level);
}

PLAIT_END_NAMESPACE
