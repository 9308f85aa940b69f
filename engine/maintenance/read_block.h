// maintenance/read_block.h: reads blocks of a store to compare, copy or repair them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <span>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/session.h"
#include "plait/store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Has the blocks in memory that another block is decoded or made from. Must not outlive the store.
class PinnedContext {
 public:
  /// An attribute's number in `needed` is its AttributeId. Errors: those of Session::pin_many.
  PinnedContext(const Store& store, std::span<const ContextBlock> needed);
  std::span<const std::span<const std::byte>> bytes() const { return bytes_; }

 private:
  Session session_;
  std::vector<PinnedBlock> pinned_;
  std::vector<std::span<const std::byte>> bytes_;
};

/// If other blocks are needed to decode it, the pager reads these. REQUIRES: the pager has no
/// changed blocks. Errors: those of Backend::read(); kBudget if the needed blocks do not fit.
void read_block(const Store& store, AttributeId attribute, int level, std::uint64_t block,
                std::span<std::byte> into);

/// Reads blocks in ascending order from their files, past the pager. It reads the rest of a run
/// when its first block is asked for. Takes the memory of one run, or of one block if that is
/// larger.
class RunBuffer {
 public:
  /// REQUIRES and errors: as read_block(), of this block alone; std::bad_alloc.
  void read(const Store& store, AttributeId attribute, int level, std::uint64_t block);

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  void read_run(const LevelFile& file);

  const LevelFile* file_ = nullptr;
  BlockRange blocks_;  ///< that were read of it
  std::vector<std::exception_ptr> errors_;
  std::unique_ptr<std::byte, Free> memory_;  ///< with the alignment of frames
  std::uint64_t bytes_ = 0;
};

// The session of a sweep that reads each block of a level
// once, beside another session that does the work.

/// If a block of the level can be read without other blocks, the session gets a small share of the
/// budget, which is enough for reading ahead. The rest is for the session that does the work.
/// Errors: kOutOfMemory.
Session open_source_session(const Store& store, const LevelFile& level);

/// The bytes of the store's frames that passes over its levels, of one attribute at a time, can do
/// without: all but those for reading ahead if no block needs others, otherwise none.
std::uint64_t spare_source_bytes(const Store& store);

PLAIT_END_NAMESPACE
