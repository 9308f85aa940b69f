// The threads that have pins in a session. A thread counts its pins without a lock: the pager asks
// who has pins only when a call can get no frame.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A thread, and the number of its pins that have not ended. Another thread may end them. An entry
/// without pins is free for any thread.
///
/// One word holds the thread's number and the pins, so a thread that counts a pin in an entry that
/// another thread has taken over fails. The session is gone after the last pin of a session that
/// has ended: so nobody may use the entry or the session after ended() has returned false.
class alignas(64) SessionCaller {
 public:
  std::uint32_t thread() const noexcept { return static_cast<std::uint32_t>(word_.load() >> 32); }
  std::uint32_t pins() const noexcept {
    return static_cast<std::uint32_t>(word_.load()) & ~kSessionEnded;
  }
  /// Counts pins of the thread if the entry is the thread's or, with `take_over`, if it is free.
  bool try_add(std::uint32_t thread, std::uint32_t pins, bool take_over) noexcept;
  /// Returns whether these were the last pins of the entry in a session that has ended.
  bool end(std::uint32_t pins) noexcept {
    const auto before = static_cast<std::uint32_t>(word_.fetch_sub(pins));
    return before == (pins | kSessionEnded);
  }
  /// Returns the pins that are left.
  std::uint32_t end_session() noexcept {
    return static_cast<std::uint32_t>(word_.fetch_or(kSessionEnded));
  }

 private:
  static constexpr std::uint32_t kSessionEnded = std::uint32_t{1} << 31;

  std::atomic<std::uint64_t> word_ = 0;
};

class SessionCallers {
 public:
  SessionCallers() = default;
  ~SessionCallers();
  SessionCallers(const SessionCallers&) = delete;
  SessionCallers& operator=(const SessionCallers&) = delete;

  /// Counts pins of the calling thread, without a lock. Returns nullptr if no entry is free.
  SessionCaller* try_add(std::uint32_t pins) noexcept;
  /// The same with the pager's lock; makes entries. Errors: std::bad_alloc.
  SessionCaller& add(std::uint32_t pins);

  // With the pager's lock.
  /// Whether is(thread) is true for a thread that has pins.
  template <class Is>
  bool any_of(Is is) const {
    for (const Entries* entries = &first_; entries; entries = entries->next.load())
      for (const SessionCaller& caller : entries->callers)
        if (caller.pins() > 0 && is(caller.thread())) return true;
    return false;
  }
  /// The session ends. Returns whether no pins are left. Otherwise, whoever ends the last pins of
  /// an entry calls end_one().
  bool end_session() noexcept;
  /// Returns whether no pins are left.
  bool end_one() noexcept { return --left_ == 0; }

 private:
  struct Entries {
    std::array<SessionCaller, 8> callers;
    std::atomic<Entries*> next = nullptr;
  };

  Entries first_;
  std::uint32_t left_ = 0;  ///< entries with pins after the end of the session
};

PLAIT_END_NAMESPACE
