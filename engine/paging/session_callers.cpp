#include "paging/session_callers.h"

#include <memory>

#include "base/contention.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

bool SessionCaller::try_add(std::uint32_t thread, std::uint32_t pins, bool take_over) noexcept {
  const std::uint64_t mine = std::uint64_t{thread} << 32;
  std::uint64_t word = word_.load();
  while (true) {
    const bool is_mine = word >> 32 == thread;
    if (!is_mine && (!take_over || static_cast<std::uint32_t>(word) != 0)) return false;
    if (word_.compare_exchange_weak(word, is_mine ? word + pins : mine | pins)) return true;
  }
}

SessionCallers::~SessionCallers() {
  for (Entries* next = first_.next.load(); next;) {
    const std::unique_ptr<Entries> entries(next);
    next = entries->next.load();
  }
}

SessionCaller* SessionCallers::try_add(std::uint32_t pins) noexcept {
  const std::uint32_t thread = this_thread_number();
  for (const bool take_over : {false, true})
    for (Entries* entries = &first_; entries; entries = entries->next.load())
      for (std::size_t i = 0; i < entries->callers.size(); ++i) {
        // Each thread begins at another entry, so most find theirs at once.
        SessionCaller& caller = entries->callers[(thread + i) % entries->callers.size()];
        if (caller.try_add(thread, pins, take_over)) return &caller;
      }
  return nullptr;
}

SessionCaller& SessionCallers::add(std::uint32_t pins) {
  while (true) {
    if (SessionCaller* const caller = try_add(pins)) return *caller;
    auto more = std::make_unique<Entries>();
    more->next = first_.next.load();
    first_.next = more.release();
  }
}

bool SessionCallers::end_session() noexcept {
  for (Entries* entries = &first_; entries; entries = entries->next.load())
    for (SessionCaller& caller : entries->callers)
      if (caller.end_session() > 0) ++left_;
  return left_ == 0;
}

PLAIT_END_NAMESPACE
