#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <vector>

#include "base/caught.h"
#include "built_in_backends.h"
#include "level_file.h"
#include "rest_of_run.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class PreadBackend final : public Backend {
 public:
  explicit PreadBackend(const LevelSpec& level)
      : geometry_(level.geometry),
        table_(level.table),
        mode_(level.mode),
        first_byte_(level.first_byte),
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
        file_.read_at(first_byte_ + geometry_.block_offset(blocks.first), into);
        break;
      }
    check_raw(geometry_, table_, blocks, into, file_.path());
  }

  void write(BlockRange blocks, std::span<const std::byte> from) override {
    check_writable(file_, mode_);
    check_request(geometry_, blocks, from.size());
    file_.write_at(first_byte_ + geometry_.block_offset(blocks.first), from);
    note_in_file(blocks);
    seal_raw(geometry_, table_, blocks, from, first_byte_);
  }

  void start_run(std::span<Transfer* const> run) noexcept override {
    RestOfRun rest(run, first_byte_ + geometry_.block_offset(run.front()->block));
    while (!rest.empty()) {
      const std::size_t before = rest.moved_blocks();
      std::exception_ptr error;
      try {
        move(run.front()->direction, rest);
      } catch (...) {
        error = caught_exception();
      }
      const std::size_t moved = rest.moved_blocks();
      // The error is that of the block in which the call stopped. The others are tried as well.
      if (error) rest.leave_out_block();
      end_moved(run.subspan(before, moved - before));
      if (error) run[moved]->listener->finished(*run[moved], error);
    }
  }

  void advise(BlockRange, Advice advice) noexcept override {
    if (advice == Advice::kSequential) advise_sequential(file_);
  }

  void sync(bool durable) override {
    if (durable) file_.sync();
  }
  std::uint64_t stored_bytes() const override { return fixed_file_bytes(geometry_); }

 private:
  /// Moves all of the rest, or throws where it stopped.
  void move(Transfer::Direction direction, RestOfRun& rest) {
    const bool read = direction == Transfer::Direction::kRead;
    if (!read) check_writable(file_, mode_);
    while (!rest.empty())
      rest.move_on(read ? file_.read_some(rest.offset(), rest.pieces())
                        : file_.write_some(rest.offset(), rest.pieces()));
  }

  void end_moved(std::span<Transfer* const> run) noexcept {
    if (run.empty()) return;
    const bool read = run.front()->direction == Transfer::Direction::kRead;
    std::exception_ptr of_all;
    try {
      if (!read) note_in_file({run.front()->block, run.size()});
    } catch (...) {
      of_all = caught_exception();
    }
    for (Transfer* const transfer : run) {
      std::exception_ptr error = of_all;
      try {
        if (read)
          check_raw(geometry_, table_, {transfer->block, 1}, transfer->memory, file_.path());
        else if (!error)
          seal_raw(geometry_, table_, {transfer->block, 1}, transfer->memory, first_byte_);
      } catch (...) {
        error = caught_exception();
      }
      transfer->listener->finished(*transfer, error);
    }
  }

  /// Notes that the file has these blocks now. A new block does not change again soon, so the disk
  /// can write it while the caller computes, and not only when the caller syncs. For blocks that a
  /// sweep reads and overwrites, it is faster to let the system choose the time
  /// (docs/benchmarks.md).
  void note_in_file(BlockRange blocks) {
    const std::span<std::uint8_t> in_file = std::span(in_file_).subspan(blocks.first, blocks.count);
    if (std::ranges::find(in_file, std::uint8_t{1}) == in_file.end())
      start_writing(file_, fixed_bytes(geometry_, blocks, first_byte_));
    std::ranges::fill(in_file, std::uint8_t{1});
  }

  bool is_written(std::uint64_t block) const {
    return table_[block].encoding != BlockEncoding::kNeverWritten;
  }

  const LevelGeometry& geometry_;
  BlockTable& table_;
  OpenMode mode_;
  std::uint64_t first_byte_;
  File file_;
  std::vector<std::uint8_t> in_file_;  ///< [block] not 0: the file has the block
};

}  // namespace

std::unique_ptr<Backend> open_pread_backend(const LevelSpec& level) {
  return std::make_unique<PreadBackend>(level);
}

PLAIT_END_NAMESPACE
