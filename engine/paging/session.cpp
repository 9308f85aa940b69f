#include "plait/extend/session.h"

#include <boost/container/small_vector.hpp>
#include <cassert>
#include <utility>

#include "paging/pager_implementation.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PinnedBlock::PinnedBlock(SessionState& session, std::uint32_t caller, Frame& frame,
                         LevelFile* written) noexcept
    : session_(&session),
      frame_(&frame),
      written_(written),
      bytes_(frame.transfer.memory),
      caller_(caller) {}

PinnedBlock::PinnedBlock(PinnedBlock&& other) noexcept
    : session_(std::exchange(other.session_, nullptr)),
      frame_(other.frame_),
      written_(other.written_),
      bytes_(other.bytes_),
      caller_(other.caller_) {}

PinnedBlock& PinnedBlock::operator=(PinnedBlock&& other) noexcept {
  if (this != &other) {
    release();
    session_ = std::exchange(other.session_, nullptr);
    frame_ = other.frame_;
    written_ = other.written_;
    bytes_ = other.bytes_;
    caller_ = other.caller_;
  }
  return *this;
}

void PinnedBlock::end(bool abandoned) noexcept {
  SessionState* const session = std::exchange(session_, nullptr);
  if (!session) return;
  Pager::Implementation& pager = *session->pager;
  if (!pager.is_usable()) return;
  auto lock = pager.lock();
  pager.unpin(lock, *session, caller_, *frame_, written_, abandoned);
  pager.unpinned();
}

void PinnedBlock::release_all(std::span<PinnedBlock> pinned) noexcept {
  Pager::Implementation* pager = nullptr;
  std::unique_lock<std::mutex> lock;
  for (PinnedBlock& pin : pinned) {
    SessionState* const session = std::exchange(pin.session_, nullptr);
    if (!session || !session->pager->is_usable()) continue;
    if (!pager) {
      pager = session->pager;
      lock = pager->lock();
    }
    pager->unpin(lock, *session, pin.caller_, *pin.frame_, pin.written_, false);
  }
  if (pager) pager->unpinned();
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
  SessionState* const state = std::exchange(state_, nullptr);
  if (state) state->pager->end_session(*state);
}

PinnedBlock Session::pin_one(const BlockRequest& request) {
  Frame* frame = nullptr;
  const std::uint32_t caller = state_->pager->pin(*state_, {&request, 1}, {&frame, 1});
  return PinnedBlock(*state_, caller, *frame, request.written());
}

PinnedBlock Session::pin(LevelFile& level, std::uint64_t block, Access access) {
  return pin_one(BlockRequest(level, block, access));
}

PinnedBlock Session::pin(const LevelFile& level, std::uint64_t block) {
  return pin_one(BlockRequest(level, block));
}

void Session::pin_many(std::span<const BlockRequest> requests, std::span<PinnedBlock> pinned) {
  assert(pinned.size() == requests.size());
  PinnedBlock::release_all(pinned);
  if (requests.empty()) return;
  boost::container::small_vector<Frame*, 16> frames(requests.size());
  const std::uint32_t caller =
      state_->pager->pin(*state_, requests, {frames.data(), frames.size()});
  for (std::size_t i = 0; i < requests.size(); ++i)
    pinned[i] = PinnedBlock(*state_, caller, *frames[i], requests[i].written());
}

bool Session::prefetch(const LevelFile& level, std::uint64_t block) noexcept {
  return state_->pager->prefetch(*state_, level, block);
}

void Session::end_prefetch() noexcept { state_->pager->end_prefetch(*state_); }

PagingStatistics Session::statistics() const { return state_->pager->statistics(*state_); }

PLAIT_END_NAMESPACE
