#include "pread/pread_backend.h"

#include <algorithm>

#include "level_file.h"

namespace plait {
namespace {

class PreadBackend final : public Backend {
 public:
  explicit PreadBackend(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        file_(open_fixed_file(level)) {}

  void read(BlockRange blocks, std::span<std::byte> into) override {
    check_request(geometry_, blocks, into.size());
    // One call reads all blocks. Never-written blocks are holes in the file, which cost no disk
    // access.
    if (any_written(blocks)) file_.read_at(geometry_.block_offset(blocks.first), into);
    check_raw(geometry_, table_, blocks, into, file_.path());
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    const bool fresh = !any_written(blocks);
    file_.write_at(geometry_.block_offset(blocks.first), from);
    // A new block does not change again soon, so the disk can write it while the caller computes,
    // and not only when the caller syncs. For blocks that a sweep reads and overwrites, it is
    // faster to let the system choose the time (plait_bench_loop_to_disk, plait_bench_sweep_rmw).
    if (fresh) start_writing(file_, fixed_bytes(geometry_, blocks));
    seal_raw(geometry_, table_, blocks, from);
  }

  void advise(BlockRange blocks, Advice advice) noexcept override {
    advise_file(file_, fixed_bytes(geometry_, blocks), advice);
  }

  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  bool any_written(BlockRange blocks) const {
    const auto entries = std::span<const BlockEntry>(table_.entries());
    return std::ranges::any_of(entries.subspan(blocks.first, blocks.count), [](const auto& entry) {
      return entry.encoding != BlockEncoding::kNeverWritten;
    });
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  File file_;
};

}  // namespace

std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level) {
  return std::make_unique<PreadBackend>(level);
}

}  // namespace plait
