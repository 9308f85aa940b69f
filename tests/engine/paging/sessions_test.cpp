// The rules of plait/extend/session.h on frames without blocks: whose frame goes first, who waits
// for whom.
#include "paging/sessions.h"

#include <catch2/catch.hpp>
#include <deque>
#include <thread>

#include "paging/frame_pool.h"

using namespace plait;

namespace {

constexpr std::uint64_t kFrameBytes = 4096;

struct Fixture {
  explicit Fixture(std::uint64_t frames_in_budget)
      : pool(frames_in_budget * kFrameBytes), sessions(pool) {}
  ~Fixture() {
    for (SessionState& session : opened)
      if (!session.ended) sessions.end(session);
  }
  Fixture(const Fixture&) = delete;
  Fixture& operator=(const Fixture&) = delete;
  SessionState& open(const SessionOptions& options = {}) {
    SessionState& session = opened.emplace_back(nullptr, options);
    sessions.add(session);
    return session;
  }
  /// A frame of this session whose block ends before edge `order`, not pinned.
  Frame& add(SessionState& session, EdgeId order, bool announced = false,
             std::uint64_t bytes = kFrameBytes) {
    Frame& frame = frames.emplace_back();
    frame.index = static_cast<std::uint32_t>(frames.size() - 1);
    frame.content.frame_bytes = bytes;
    frame.content.order = order;
    sessions.give(frame, &session);
    if (announced) sessions.announce(frame);
    sessions.place(frame);
    return frame;
  }
  Frame* victim(const SessionState& asking) { return sessions.victim(asking, kFrameBytes); }
  void evict(Frame& frame) { sessions.give(frame, nullptr); }
  bool may_come_free_elsewhere(const SessionState& asking) const {
    bool result = false;
    std::thread([&] { result = sessions.may_come_free(asking); }).join();
    return result;
  }

  FramePool pool;
  Sessions sessions;
  std::deque<SessionState> opened;
  std::deque<Frame> frames;
};

}  // namespace

TEST_CASE("SessionsVictim_Window_IsTheBlockThatEndsFurthestBehind") {
  Fixture f(8);
  SessionState& session = f.open();
  Frame& ahead = f.add(session, 30);
  Frame& behind = f.add(session, 10);
  Frame& middle = f.add(session, 20);
  for (Frame* const expected : {&behind, &middle, &ahead}) {
    CHECK(f.victim(session) == expected);
    f.evict(*expected);
  }
  CHECK(f.victim(session) == nullptr);
}

TEST_CASE("SessionsVictim_WindowOfSeveralSizes_IsTheFirstOfTheWantedSize") {
  Fixture f(64);
  SessionState& session = f.open();
  Frame& small = f.add(session, 10);
  Frame& large = f.add(session, 20, false, 4 * kFrameBytes);
  Frame& next_large = f.add(session, 30, false, 4 * kFrameBytes);
  CHECK(f.sessions.victim(session, 4 * kFrameBytes) == &large);
  CHECK(f.sessions.victim(session, kFrameBytes) == &small);
  CHECK(f.sessions.victim(session, 2 * kFrameBytes) == &small);  // there is none of this size
  f.evict(large);
  f.add(session, 31);
  CHECK(f.sessions.victim(session, 4 * kFrameBytes) == &next_large);
  // The window has not passed it yet.
  f.evict(next_large);
  f.add(session, 40, false, 4 * kFrameBytes);
  f.add(session, 32);
  CHECK(f.sessions.victim(session, 4 * kFrameBytes) == &small);
  // More frames have piled up than will soon be wanted.
  f.add(session, 41);
  CHECK(f.sessions.victim(session, 4 * kFrameBytes)->content.frame_bytes == 4 * kFrameBytes);
  for (EdgeId order = 42; order < 100; ++order) f.add(session, order);
  f.add(session, 100, false, 4 * kFrameBytes);
  f.add(session, 99);
  f.evict(*f.sessions.victim(session, 4 * kFrameBytes));
  CHECK(f.sessions.victim(session, 4 * kFrameBytes) == &small);
}

TEST_CASE("SessionsVictim_Clock_SparesOnceWhatCameBack") {
  Fixture f(8);
  SessionState& session = f.open({.policy = EvictionPolicy::kClock});
  Frame& first = f.add(session, 3);
  Frame& second = f.add(session, 2);
  Frame& third = f.add(session, 1);
  CHECK(f.victim(session) == &first);  // the hand went round once
  Sessions::unplace(second);           // pinned
  f.sessions.place(second);            // and back
  f.evict(first);
  CHECK(f.victim(session) == &third);
  f.evict(third);
  CHECK(f.victim(session) == &second);
}

TEST_CASE("SessionsVictim_SeveralSessions_IsOfTheOneFurthestOverItsShare") {
  Fixture f(8);
  SessionState& little = f.open({.share_bytes = kFrameBytes});
  SessionState& much = f.open({.share_bytes = 6 * kFrameBytes});
  Frame& a = f.add(little, 1);
  Frame& b = f.add(little, 2);
  for (EdgeId i = 0; i < 6; ++i) f.add(much, i);
  CHECK(f.victim(much) == &a);  // both are over by one; the asking one only if it got more
  f.evict(a);
  CHECK(f.victim(much)->content.session == &much);
  CHECK(f.victim(little) == &b);
}

TEST_CASE("SessionsShare_NoneGiven_IsAnEqualPartOfWhatTheOthersLeave") {
  Fixture f(8);
  SessionState& first = f.open();
  CHECK(f.sessions.share_bytes(first) == 8 * kFrameBytes);
  SessionState& second = f.open();
  SessionState& fixed = f.open({.share_bytes = 2 * kFrameBytes});
  CHECK(f.sessions.share_bytes(first) == 3 * kFrameBytes);
  CHECK(f.sessions.share_bytes(second) == 3 * kFrameBytes);
  CHECK(f.sessions.share_bytes(fixed) == 2 * kFrameBytes);
  SessionState& greedy = f.open({.share_bytes = 100 * kFrameBytes});
  CHECK(f.sessions.share_bytes(greedy) == 8 * kFrameBytes);
  CHECK(f.sessions.share_bytes(first) == 0);
}

TEST_CASE("SessionsEnd_WhatIsLeft_GoesFirstInTheOrderOfItsPolicy") {
  Fixture f(8);
  SessionState& ending = f.open();
  SessionState& staying = f.open();
  Frame& kept = f.add(staying, 0);
  Frame& later = f.add(ending, 20);
  Frame& sooner = f.add(ending, 10);
  Frame& announced = f.add(ending, 5, true);
  f.sessions.end(ending);
  for (Frame* const expected : {&sooner, &later, &announced, &kept}) {
    CHECK(f.victim(staying) == expected);
    f.evict(*expected);
  }
  CHECK(ending.frame_bytes == 0);
  CHECK(ending.announced_bytes == 0);
}

TEST_CASE("SessionsGive_AnnouncedFrame_IsAnnouncedNoMore") {
  Fixture f(8);
  SessionState& first = f.open();
  SessionState& second = f.open();
  Frame& near = f.add(first, 10, true);
  Frame& far = f.add(first, 20, true);
  CHECK(first.announced_bytes == 2 * kFrameBytes);
  CHECK(f.victim(first) == nullptr);
  CHECK(f.sessions.last_announced(first, kFrameBytes) == &far);
  f.sessions.give(far, &second);
  CHECK(first.announced_bytes == kFrameBytes);
  CHECK(first.frame_bytes == kFrameBytes);
  CHECK(second.frame_bytes == kFrameBytes);
  CHECK(f.sessions.last_announced(first, kFrameBytes) == &near);
  f.evict(near);
  f.evict(far);
}

TEST_CASE("SessionsMayComeFree_PinsOfOthers_UnlessTheirThreadsWait") {
  Fixture f(8);
  SessionState& asking = f.open();
  SessionState& holding = f.open();
  CHECK_FALSE(f.may_come_free_elsewhere(asking));
  SessionCaller& here = holding.callers.add(1);
  CHECK(f.may_come_free_elsewhere(asking));
  CHECK_FALSE(f.sessions.may_come_free(asking));  // this thread holds it itself
  CHECK_FALSE(f.may_come_free_elsewhere(holding));
  {
    SessionState& third = f.open();
    const Sessions::Waiter waiter(f.sessions, third);  // this thread waits, in another session
    CHECK_FALSE(f.may_come_free_elsewhere(asking));
  }
  std::thread([&] {
    const Sessions::Waiter waiter(f.sessions, holding);  // some thread of that session waits
    CHECK_FALSE(f.may_come_free_elsewhere(asking));
  }).join();
  CHECK(f.may_come_free_elsewhere(asking));
  here.end(1);
  CHECK_FALSE(f.may_come_free_elsewhere(asking));
}
