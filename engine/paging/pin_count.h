// How many pins a frame has, and whether a thread may add or end one without the pager's lock.
//
// One atomic word holds the count, three flags, and how many blocks the frame has had. It is
// changed only by atomic read-modify-write operations, so each change sees the one before. Who may
// do what:
//
//  - Any thread, without the lock: adds a pin while the frame is open (try_add), and ends one
//    unless that leaves a frame without pins that is not placed (try_end); sets kUsed.
//  - Whoever has the lock: everything else. Nobody else sets or clears kOpen and kPlaced.
//
// A thread that adds a pin reads the word, then asks the table of frames whether the frame has the
// block that it wants, and then changes the word from what it read. If the frame was given to
// another block in between, the number of blocks differs, and the change fails. So a thread never
// pins another block than its own, not even for a moment.
//
//   kOpen    Threads of the frame's session may pin it without the lock.
//   kPlaced  The frame is in the list of an eviction policy. So its last pin may end without the
//            lock. The last pin of another frame must end with the lock, because the thread that
//            ends it frees the frame, writes its block or places it.
//   kUsed    A thread has pinned the frame without the lock, or is about to, since the policy last
//            asked.
//
// What the lock's holder may rely on:
//  (a) A closed frame gets no pin. So if it has none, it keeps none until the lock is released.
//  (b) A frame that is not placed keeps its last pin until the lock is released.
//  (c) A frame that is open and not placed has a pin when the lock is released. So no thread brings
//      an unplaced frame from no pin to one and back while nobody looks.
//
// Eviction: claim() closes a frame if it has no pins. Otherwise it says that the frame is no longer
// placed, and the thread that ends the last pin places it again. Both in one step, so no pin can
// end between the look and the decision.
//
// Memory orders: opening releases, and adding a pin acquires: the thread sees the frame as the
// lock's holder left it. Ending a pin releases, and closing acquires: all use of the bytes comes
// before the memory is used again. Between the two there are only read-modify-write operations, so
// they all belong to the release sequences. All are seq_cst, because the end of a pin is followed
// by a look whether anybody waits (Sessions::anybody_waits).
// Pinned by tests/engine/paging/open_pins_test.cpp.
#pragma once

#include <atomic>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class PinCount {
 public:
  /// Adds a pin if the frame is open and has_block() is true.
  template <class HasBlock>
  bool try_add(HasBlock has_block) noexcept {
    Word word = word_.load();
    const Word blocks = word / kBlock;
    if ((word & kOpen) == 0 || !has_block()) return false;
    while ((word & kOpen) != 0 && word / kBlock == blocks)
      if (word_.compare_exchange_weak(word, (word + 1) | kUsed)) return true;
    return false;
  }
  /// Ends a pin, unless the lock is needed for that. REQUIRES: the caller has a pin.
  bool try_end() noexcept {
    Word word = word_.load();
    while (pins(word) > 1 || (word & kPlaced) != 0)
      if (word_.compare_exchange_weak(word, word - 1)) return true;
    return false;
  }
  /// Says that the block is in use, if that is not known. The frame may have got another block.
  void keep_used() noexcept {
    if ((word_.load(std::memory_order_relaxed) & kUsed) == 0) word_.fetch_or(kUsed);
  }
  bool is_open() const noexcept { return (word_.load(std::memory_order_acquire) & kOpen) != 0; }

  // With the pager's lock.
  std::uint32_t count() const noexcept { return pins(word_.load()); }
  bool any() const noexcept { return count() > 0; }
  /// Adds a pin, and opens or closes the frame. REQUIRES: it is not placed.
  void add(bool open) noexcept {
    Word word = word_.load();
    while (!word_.compare_exchange_weak(word, ((word & ~kOpen) + 1) | (open ? kOpen : 0))) {
    }
  }
  /// Ends a pin. Returns whether that was the last one of a frame that is not placed. The frame is
  /// then closed, and the caller decides what becomes of it. REQUIRES: the caller has a pin.
  bool end() noexcept {
    Word word = word_.load(), next = 0;
    bool is_last = false;
    do {
      is_last = pins(word) == 1 && (word & kPlaced) == 0;
      next = is_last ? (word - 1) & ~kOpen : word - 1;
    } while (!word_.compare_exchange_weak(word, next));
    return is_last;
  }
  /// REQUIRES: the frame is placed, or it has a pin.
  void open() noexcept { word_.fetch_or(kOpen); }
  /// Returns whether the frame has no pins.
  bool close() noexcept { return pins(word_.fetch_and(~kOpen)) == 0; }
  /// Closes the frame if it has no pins. Otherwise it is no longer placed, and the caller removes
  /// it from its list.
  bool claim() noexcept {
    Word word = word_.load();
    while (true)
      if (pins(word) > 0) {
        if (word_.compare_exchange_weak(word, word & ~kPlaced)) return false;
      } else if (word_.compare_exchange_weak(word, word & ~kOpen)) {
        return true;
      }
  }
  /// REQUIRES: the frame is closed and has no pins.
  void set_placed() noexcept { word_.fetch_or(kPlaced); }
  void set_unplaced() noexcept { word_.fetch_and(~kPlaced); }
  /// The frame's block leaves it. REQUIRES: the frame is closed and has no pins.
  void end_block() noexcept { word_.fetch_add(kBlock); }
  void set_used() noexcept { word_.fetch_or(kUsed); }
  bool take_used() noexcept { return (word_.fetch_and(~kUsed) & kUsed) != 0; }

 private:
  using Word = std::uint64_t;
  static constexpr Word kOpen = Word{1} << 28, kPlaced = Word{1} << 29, kUsed = Word{1} << 30,
                        kBlock = Word{1} << 31;
  static constexpr std::uint32_t pins(Word word) {
    return static_cast<std::uint32_t>(word & (kOpen - 1));
  }

  std::atomic<Word> word_ = 0;
};

PLAIT_END_NAMESPACE
