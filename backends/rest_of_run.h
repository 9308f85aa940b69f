// backends/rest_of_run.h: the part of a run (Backend::start_run) that is not moved yet. A system
// call may stop in the middle of a block.
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plait/extend/backend.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class RestOfRun {
 public:
  /// `offset` is that of the first block in the file. The blocks lie one after another.
  RestOfRun(std::span<Transfer* const> run, std::uint64_t offset) : offset_(offset) {
    for (const Transfer* const transfer : run) pieces_.push_back(transfer->memory);
  }

  bool empty() const noexcept { return first_ == pieces_.size(); }
  /// The number of blocks that are moved, or left out. The next one is being moved.
  std::size_t moved_blocks() const noexcept { return first_; }
  std::uint64_t offset() const noexcept { return offset_; }
  /// The memory of the rest, block by block.
  std::span<const std::span<std::byte>> pieces() const noexcept {
    return std::span(pieces_.data(), pieces_.size()).subspan(first_);
  }
  std::uint64_t bytes() const noexcept {
    std::uint64_t bytes = 0;
    for (const std::span<std::byte> piece : pieces()) bytes += piece.size();
    return bytes;
  }

  /// REQUIRES: the rest has at least `bytes`.
  void move_on(std::uint64_t bytes) noexcept {
    offset_ += bytes;
    for (; bytes > 0; ++first_) {
      std::span<std::byte>& piece = pieces_[first_];
      if (bytes < piece.size()) {
        piece = piece.subspan(bytes);
        return;
      }
      bytes -= piece.size();
    }
  }
  /// Leaves the rest of the next block out. REQUIRES: the rest is not empty.
  void leave_out_block() noexcept { offset_ += pieces_[first_++].size(); }

 private:
  std::uint64_t offset_;
  std::size_t first_ = 0;
  boost::container::static_vector<std::span<std::byte>, kMostRunBlocks> pieces_;
};

PLAIT_END_NAMESPACE
