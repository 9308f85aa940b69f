// uring_runs.h: runs of blocks under way in the ring.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "plait/detail/level_file.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "uring/page_buffers.h"
#include "uring/uring_ring.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A level as its requests need it. It must outlive them.
struct UringLevel {
  const LevelGeometry& geometry;
  BlockTable& table;
  OpenMode mode;
  std::uint64_t first_byte;
  UringRing& ring;
  PageBuffers& buffers;
  std::function<void(const std::string&)> tell;
  File file;    ///< goes through the page cache
  File direct;  ///< goes past the page cache; not open if the file system has no O_DIRECT
  std::atomic<bool> goes_past_cache;

  int descriptor(bool past_cache) const noexcept {
    return past_cache ? direct.descriptor() : file.descriptor();
  }
  /// A file system may refuse O_DIRECT only when a transfer comes.
  void give_up_direct() noexcept;
};

inline void tell_slower(const std::function<void(const std::string&)>& tell,
                        const std::string& reason) {
  tell(reason + "; its blocks go through the page cache");
}

/// Whether O_DIRECT can move this piece of a run.
bool is_aligned(std::span<const std::byte> piece) noexcept;

/// Begins transfers of adjacent blocks that go out in one request, and tells the listener of each
/// when it has ended. `aligned` is a page buffer that they may need. Of a request that fails, the
/// transfers before the failed block succeed, and those behind it begin again.
void start_together(UringLevel& level, std::span<Transfer* const> run,
                    PageBuffers::Lease aligned) noexcept;

PLAIT_END_NAMESPACE
