// One call that pins blocks. All frames of a call are had before its first read begins, and given
// up before the call waits for anybody who may wait for it. So no two calls wait for each other.
//
// A call that brings blocks in waits for reads of others, too: at its end, when all of its own are
// under way, and before it begins the read of a block that is coded by others. The latter come
// earlier in the order of (level, attribute), and whoever brings in a block that comes earlier
// waits only for still earlier ones. So these waits end as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "paging/pager_implementation.h"
#include "paging/pin_batch.h"

namespace plait {

/// Lives while the lock is held, which it lets go of where it says so.
class Pager::Implementation::PinCall {
 public:
  /// Errors: std::bad_alloc.
  PinCall(Implementation& pager, Lock& lock, SessionState& session,
          std::span<const BlockRequest> requests)
      : pager_(pager), lock_(lock), session_(session), requests_(requests), batch_(requests) {}

  /// Pins requests[i] in frames[i], all of them, or leaves nothing behind. Lets go of the lock.
  /// Errors: those of Session::pin_many; std::bad_alloc.
  void run(std::span<Frame*> frames);

 private:
  class UnderWay;

  // pin_call.cpp
  /// Takes a frame for each block of the batch, and adds the blocks that these are coded by. False:
  /// it took none, and waited.
  bool take_frames();
  void add_context(std::size_t at);
  /// Frees a frame, or waits for what may free one; the batch keeps what it took. False: it has let
  /// go of that.
  bool make_room(const LevelFile& wanted_by);
  [[noreturn]] void refuse_room(std::uint64_t needed_bytes);
  void check_may_write();
  void add_writer(std::size_t at) noexcept;
  /// What was taken and brought in is given up.
  void let_go() noexcept;

  // bring_in.cpp
  /// Begins all reads, then waits. False: the read of another call failed, begin anew.
  /// Errors: that of a read that this call began.
  bool bring_in();
  void read() noexcept;
  void read_with_context() noexcept;
  void fill_with_zeros() noexcept;

  Implementation& pager_;
  Lock& lock_;
  SessionState& session_;
  std::span<const BlockRequest> requests_;
  PinBatch batch_;
};

}  // namespace plait
