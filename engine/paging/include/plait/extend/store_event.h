// plait/extend/store_event.h: what a store tells a program's log or metrics.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Something that a store did. Texts are valid during the call.
struct StoreEvent {
  enum class Kind : std::uint8_t {
    kOpened,     ///< create() or open() has ended
    kCommitted,  ///< commit() has made a version
    kEvicted,    ///< a block left memory, because others needed its room
    kSlowRead,   ///< a block was read, and that took long
  };
  Kind kind = Kind::kOpened;
  std::string_view store = {};    ///< its path; empty for a store in memory
  std::uint64_t version = 0;      ///< opened, committed: Store::sequence()
  std::uint64_t duration_ns = 0;  ///< all but evicted; of a read, with its time in the queue
  // Evicted and slow read:
  std::string_view attribute = {};  ///< the name that it had when its level was opened
  int level = 0;
  std::uint64_t block = 0, bytes = 0;  ///< bytes before compression
};

/// Whom a store tells of events. Calls come from any thread that uses the store and from its I/O
/// threads, several at the same time, with no lock held. The call should return soon, because a
/// read waits for it. It may take Store::statistics(), and call no other function of the store.
/// What it throws is lost. No call comes after close() has returned, nor after the store and all
/// its readers and views are gone. While readers or views live after the Store object, calls may
/// come that have no Store to ask.
struct StoreEvents {
  std::function<void(const StoreEvent&)> call = {};
  std::uint64_t slow_read_ns = 100'000'000;  ///< a read that takes longer is slow

  void tell(const StoreEvent& event) const noexcept {
    if (!call) return;
    try {
      call(event);
    } catch (...) {  // a log that fails must not make a read fail
    }
  }
};

PLAIT_END_NAMESPACE
