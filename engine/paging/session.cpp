#include "plait/extend/session.h"

#include <boost/container/small_vector.hpp>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "paging/pager_implementation.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PinnedBlock::PinnedBlock(SessionState& session, SessionCaller& caller, Frame& frame,
                         LevelFile* written) noexcept
    : session_(&session),
      caller_(&caller),
      frame_(&frame),
      written_(written),
      bytes_(frame.transfer.memory) {}

PinnedBlock::PinnedBlock(PinnedBlock&& other) noexcept
    : session_(std::exchange(other.session_, nullptr)),
      caller_(other.caller_),
      frame_(other.frame_),
      written_(other.written_),
      bytes_(other.bytes_) {}

PinnedBlock& PinnedBlock::operator=(PinnedBlock&& other) noexcept {
  if (this != &other) {
    release();
    session_ = std::exchange(other.session_, nullptr);
    caller_ = other.caller_;
    frame_ = other.frame_;
    written_ = other.written_;
    bytes_ = other.bytes_;
  }
  return *this;
}

void PinnedBlock::end(bool abandoned) noexcept {
  SessionState* const session = std::exchange(session_, nullptr);
  if (!session) return;
  Pager::Implementation& pager = *session->pager;
  if (!pager.is_usable()) return;
  Pager::Implementation::Lock lock;
  pager.unpin(lock, *frame_, written_, abandoned);
  pager.unpinned(lock);
  pager.end_pins(*session, *caller_, 1);
}

void PinnedBlock::release_all(std::span<PinnedBlock> pinned) noexcept {
  Pager::Implementation::Lock lock;
  for (std::size_t first = 0; first < pinned.size();) {
    // A run of pins that one thread made in one session.
    SessionState* const session = pinned[first].session_;
    SessionCaller* const caller = pinned[first].caller_;
    std::size_t after = first;
    while (after < pinned.size() && pinned[after].session_ == session &&
           pinned[after].caller_ == caller)
      pinned[after++].session_ = nullptr;
    const std::span<PinnedBlock> run = pinned.subspan(first, after - first);
    first = after;
    if (!session || !session->pager->is_usable()) continue;
    Pager::Implementation& pager = *session->pager;
    for (const PinnedBlock& pin : run) pager.unpin(lock, *pin.frame_, pin.written_, false);
    pager.unpinned(lock);
    pager.end_pins(*session, *caller, static_cast<std::uint32_t>(run.size()));
  }
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
  SessionCaller& caller = state_->pager->pin(*state_, {&request, 1}, {&frame, 1});
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
  SessionCaller& caller = state_->pager->pin(*state_, requests, {frames.data(), frames.size()});
  for (std::size_t i = 0; i < requests.size(); ++i)
    pinned[i] = PinnedBlock(*state_, caller, *frames[i], requests[i].written());
}

bool Session::prefetch(const LevelFile& level, std::uint64_t block) noexcept {
  const bool in_order = state_->options.policy == EvictionPolicy::kLayoutOrder;
  return state_->pager->prefetch(*state_, level, block, in_order ? kMostRunBlocks : 1);
}

bool Session::read_ahead(const LevelFile& level, std::uint64_t block,
                         std::uint64_t count) noexcept {
  return state_->pager->read_ahead(*state_, level, block, count);
}

void Session::end_prefetch() noexcept { state_->pager->end_prefetch(*state_); }

PagingStatistics Session::statistics() const { return state_->pager->statistics(*state_); }

PLAIT_END_NAMESPACE
