// plait/extend/budget.h: a budget of memory that several stores of a process share.
//
//   auto budget = std::make_shared<Budget>(1 << 30);
//   Store a = Store::open(path, {.budget_bytes = 64 << 20, .budget = budget}, backends);
//   Store b = Store::open(other, {.budget_bytes = 64 << 20, .budget = budget}, backends);
//
// Each store has a part of its own: its `budget_bytes`. No other store uses it, so a sweep can plan
// with it. The budget lends the rest to stores that need more frames than their part has. A store
// gets at most an equal portion of the rest. If another store is opened, the portions become
// smaller: the stores then evict blocks that nobody has pinned, at once, and the others as soon as
// they need a frame. All frames and the scratch memory of all stores together never exceed the
// budget.
//
// Limits: the rest is divided equally, whether a store uses its portion or not. A borrowed frame
// that stays pinned stays borrowed.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Threads: shared (docs/threads.md). Stores keep it alive. A process that is forked makes a budget
/// of its own.
class Budget {
 public:
  explicit Budget(std::uint64_t bytes);
  Budget(const Budget&) = delete;
  Budget& operator=(const Budget&) = delete;

  std::uint64_t bytes() const noexcept { return bytes_; }
  /// The parts of the open stores, together.
  std::uint64_t part_bytes() const noexcept;
  /// What the open stores have borrowed beyond their parts, together.
  std::uint64_t lent_bytes() const noexcept;

  /// For use by stores only.
  class Borrower {
   public:
    virtual ~Borrower() = default;
    /// Gives back what is borrowed beyond portion_bytes(), as far as it is not pinned.
    virtual void shrink() noexcept = 0;
  };
  /// Errors: kBudget if the parts would exceed the budget, or if too much of it is lent and pinned;
  /// kBadState in another process than the one that made the budget; kOutOfMemory.
  void join(Borrower& store, std::uint64_t part_bytes);
  void leave(Borrower& store, std::uint64_t part_bytes) noexcept;
  /// Lends `more_bytes` to a store that has borrowed `lent_bytes`, or returns false.
  bool lend(std::uint64_t lent_bytes, std::uint64_t more_bytes) noexcept;
  void give_back(std::uint64_t bytes) noexcept;
  /// The most that one store may borrow now.
  std::uint64_t portion_bytes() const noexcept { return portion_bytes_; }

 private:
  bool add_part(std::uint64_t part_bytes) noexcept;
  void divide() noexcept;

  const std::uint64_t bytes_;
  const int process_;  ///< its number
  std::atomic<std::uint64_t> portion_bytes_ = 0;
  std::mutex members_mutex_;  ///< for `members_`; locked before the locks of pagers
  std::vector<Borrower*> members_;
  mutable std::mutex mutex_;  ///< for the following; locked after the locks of pagers
  std::uint64_t part_bytes_ = 0, lent_bytes_ = 0, store_count_ = 0;
};

PLAIT_END_NAMESPACE
