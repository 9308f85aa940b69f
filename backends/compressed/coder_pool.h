// backends/compressed/coder_pool.h: the coders of all levels of one store.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "compressed/block_coder.h"
#include "plait/extend/backend.h"
#include "plait/extend/pipeline_registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The properties that a coder is made for. Levels with the same Coding share coders.
struct Coding {
  PipelineStage codec;
  std::size_t buffers = 0;  ///< as in BlockCoder
  std::size_t scratch_bytes = 0;
  std::uint64_t maker_bytes = 0;  ///< what a BlockMaker uses beside the coder

  friend bool operator==(const Coding&, const Coding&) = default;
};

struct KeptCoder {
  Coding coding;
  std::unique_ptr<BlockCoder> coder;
};

/// Keeps coders for the next caller, because their memory is faulted in and their contexts are set
/// up. The pool has one coder per thread, or fewer if the memory is short. A caller waits if all
/// coders are in use. Safe from any thread.
class CoderPool {
 public:
  /// `pipelines` outlives the pool.
  CoderPool(const PipelineRegistry& pipelines, const VolumeSpec& volume);

  /// Prepares for blocks of up to `raw_bytes` with this coding. Coders for smaller blocks are freed
  /// when their users return them. Errors: as PipelineRegistry::open().
  void make_room_for(const Coding& coding, std::uint64_t raw_bytes);
  /// The coders that there may be, and how large they are.
  struct Room {
    std::uint64_t max_raw_bytes = 0, coder_bytes = 1;
    std::size_t most_coders = 1;
  };
  Room room() const;
  /// What make_room_for() makes of it. Errors: as PipelineRegistry::open().
  Room with(Room room, const Coding& coding, std::uint64_t raw_bytes) const;
  /// memory_bytes() with this room.
  std::uint64_t memory_of(const Room& room) const noexcept;
  /// The most memory that all coders together take, but not more than `most_scratch_bytes`. The
  /// pool always has one coder; if that coder alone takes more, the rest is not counted here.
  std::uint64_t memory_bytes() const noexcept;
  std::size_t most_coders() const noexcept;
  /// Frees the memory of the coders that are not in use.
  void shrink() noexcept;

  class Lease {
   public:
    /// REQUIRES: make_room_for() was called with this coding.
    Lease(CoderPool& pool, const Coding& coding) : pool_(pool), kept_(pool.take(coding)) {}
    ~Lease() { pool_.give_back(std::move(kept_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    BlockCoder& operator*() const { return *kept_.coder; }
    BlockCoder* operator->() const { return kept_.coder.get(); }

   private:
    CoderPool& pool_;
    KeptCoder kept_;
  };

 private:
  KeptCoder take(const Coding& coding);
  /// Allocates nothing.
  void give_back(KeptCoder kept) noexcept;

  const PipelineRegistry& pipelines_;
  VolumeSpec volume_;
  mutable std::mutex mutex_;
  Room room_;
  std::condition_variable given_back_;
  std::size_t taken_ = 0;
  std::vector<KeptCoder> idle_;  ///< has room for room_.most_coders
};

PLAIT_END_NAMESPACE
