#include "paging/sessions.h"

#include <algorithm>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

Sessions::Waiter::Waiter(Sessions& sessions, SessionState& session) noexcept
    : sessions_(sessions), session_(session) {
  ++session_.waiting;
  sessions_.waiters_.push_back(*this);
  ++sessions_.waiter_count_;
}

Sessions::Waiter::~Waiter() {
  --sessions_.waiter_count_;
  sessions_.waiters_.erase(sessions_.waiters_.iterator_to(*this));
  --session_.waiting;
}

void Sessions::end(SessionState& session) noexcept {
  session.ended = true;
  while (Frame* const frame = session.eviction().victim(0)) {
    give(*frame, nullptr);
    place(*frame);
  }
  while (!session.frames.empty()) {
    Frame& frame = session.frames.front();
    const bool placed = is_placed(frame);
    frame.pins.close();
    give(frame, nullptr);
    // The thread that ends the last pin of a frame places it.
    if (placed && !frame.pins.any()) place(frame);
  }
  open_.erase(open_.iterator_to(session));
}

void Sessions::give(Frame& frame, SessionState* session) noexcept {
  Frame::Content& content = frame.content;
  unplace(frame);
  SessionState* const former = content.session;
  if (former && std::exchange(content.announced, false))
    former->announced_bytes -= content.frame_bytes;
  if (former == session) return;
  if (former) {
    frame.in_session.unlink();
    former->frame_bytes -= content.frame_bytes;
  }
  content.session = session;
  if (!session) return;
  session->frames.push_back(frame);
  session->frame_bytes += content.frame_bytes;
  session->statistics.peak_frame_bytes =
      std::max(session->statistics.peak_frame_bytes, session->frame_bytes);
}

void Sessions::announce(Frame& frame) noexcept {
  if (!std::exchange(frame.content.announced, true))
    frame.content.session->announced_bytes += frame.content.frame_bytes;
}

void Sessions::withdraw(Frame& frame) noexcept {
  const bool placed = is_placed(frame);
  unplace(frame);
  frame.content.announced = false;
  frame.content.session->announced_bytes -= frame.content.frame_bytes;
  if (placed) place(frame);
}

void Sessions::unplace(Frame& frame) noexcept {
  if (!is_placed(frame)) return;
  frame.pins.set_unplaced();
  frame.in_list.unlink();
  frame.in_order.unlink();
  frame.in_need.unlink();
}

void Sessions::place(Frame& frame) noexcept {
  SessionState* const session = frame.content.session;
  if (!session)
    left_.push_back(frame);
  else if (frame.content.announced)
    session->ahead.insert(frame);
  else
    session->eviction().insert(frame);
  frame.pins.set_placed();
}

std::uint64_t Sessions::share_bytes(const SessionState& session) const noexcept {
  const std::uint64_t budget = pool_.budget_bytes();
  if (session.options.share_bytes > 0) return std::min(session.options.share_bytes, budget);
  std::uint64_t left = budget, equals = 0;
  for (const SessionState& other : open_) {
    left -= std::min(left, other.options.share_bytes);
    if (other.options.share_bytes == 0) ++equals;
  }
  return left / std::max<std::uint64_t>(equals, 1);
}

template <class Has>
SessionState* Sessions::furthest_over(const SessionState& asking, std::uint64_t wanted_bytes,
                                      Has has) noexcept {
  SessionState* result = nullptr;
  std::int64_t most = 0;
  for (SessionState& session : open_) {
    if (!has(session)) continue;
    const std::uint64_t used = session.frame_bytes + (&session == &asking ? wanted_bytes : 0);
    const auto excess =
        static_cast<std::int64_t>(used) - static_cast<std::int64_t>(share_bytes(session));
    if (result && excess <= most) continue;
    result = &session;
    most = excess;
  }
  return result;
}

Frame* Sessions::victim(const SessionState& asking, std::uint64_t wanted_bytes) noexcept {
  if (!left_.empty()) return &left_.front();
  SessionState* const session = furthest_over(asking, wanted_bytes, [&](SessionState& of) {
    return of.eviction().victim(wanted_bytes) != nullptr;
  });
  return session ? session->eviction().victim(wanted_bytes) : nullptr;
}

Frame* Sessions::last_announced(const SessionState& asking, std::uint64_t wanted_bytes) noexcept {
  SessionState* const session =
      furthest_over(asking, wanted_bytes, [](const SessionState& of) { return !of.ahead.empty(); });
  return session ? &*session->ahead.rbegin() : nullptr;
}

bool Sessions::waits(std::uint32_t thread) const noexcept {
  return thread == this_thread_number() || std::ranges::any_of(waiters_, [&](const Waiter& waiter) {
           return waiter.thread_ == thread;
         });
}

bool Sessions::may_come_free(const SessionState& asking) const noexcept {
  return std::ranges::any_of(open_, [&](const SessionState& other) {
    return &other != &asking && other.waiting == 0 &&
           other.callers.any_of([&](std::uint32_t thread) { return !waits(thread); });
  });
}

PLAIT_END_NAMESPACE
