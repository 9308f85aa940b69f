#include "plait/session.h"

#include <cassert>
#include <utility>

#include "paging/pager_implementation.h"

namespace plait {

PinnedBlock::PinnedBlock(PinnedBlock&& other) noexcept
    : session_(std::exchange(other.session_, nullptr)),
      written_(other.written_),
      frame_(other.frame_),
      caller_(other.caller_),
      bytes_(other.bytes_) {}

PinnedBlock& PinnedBlock::operator=(PinnedBlock&& other) noexcept {
  if (this != &other) {
    release();
    session_ = std::exchange(other.session_, nullptr);
    written_ = other.written_;
    frame_ = other.frame_;
    caller_ = other.caller_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void PinnedBlock::release() noexcept {
  if (SessionState* const session = std::exchange(session_, nullptr))
    session->pager.unpin(*session, caller_, frame_, nullptr);
}

void PinnedBlock::abandon() noexcept {
  if (SessionState* const session = std::exchange(session_, nullptr))
    session->pager.unpin(*session, caller_, frame_, written_);
}

Session::Session(Session&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}

Session& Session::operator=(Session&& other) noexcept {
  if (this != &other) {
    end();
    state_ = std::exchange(other.state_, nullptr);
  }
  return *this;
}

void Session::end() noexcept {
  if (SessionState* const state = std::exchange(state_, nullptr)) state->pager.end_session(*state);
}

PinnedBlock Session::pin(LevelFile& level, std::uint64_t block, Access access) {
  PinnedBlock pinned;
  const BlockRequest request(level, block, access);
  pin_many({&request, 1}, {&pinned, 1});
  return pinned;
}

PinnedBlock Session::pin(const LevelFile& level, std::uint64_t block) {
  PinnedBlock pinned;
  const BlockRequest request(level, block);
  pin_many({&request, 1}, {&pinned, 1});
  return pinned;
}

void Session::pin_many(std::span<const BlockRequest> requests, std::span<PinnedBlock> pinned) {
  assert(pinned.size() == requests.size());
  for (PinnedBlock& former : pinned) former.release();
  try {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      const Frame& frame = state_->pager.pin(*state_, requests[i], pinned[i].caller_);
      pinned[i].frame_ = frame.index;
      pinned[i].bytes_ = frame.transfer.memory;
      pinned[i].written_ = requests[i].written();
      pinned[i].session_ = state_;
    }
  } catch (...) {
    for (PinnedBlock& taken : pinned) taken.abandon();
    throw;
  }
}

bool Session::prefetch(const LevelFile& level, std::uint64_t block) noexcept {
  return state_->pager.prefetch(*state_, level, block);
}

PagingStatistics Session::statistics() const { return state_->pager.statistics(*state_); }

}  // namespace plait
