#include "plait/extend/budget.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <new>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

Budget::Budget(std::uint64_t bytes) : bytes_(bytes), process_(::getpid()) {}

std::uint64_t Budget::part_bytes() const noexcept {
  const std::lock_guard lock(mutex_);
  return part_bytes_;
}

std::uint64_t Budget::lent_bytes() const noexcept {
  const std::lock_guard lock(mutex_);
  return lent_bytes_;
}

void Budget::divide() noexcept {
  const std::uint64_t rest = bytes_ - part_bytes_;
  portion_bytes_ = store_count_ == 0 ? rest : rest / store_count_;
}

bool Budget::add_part(std::uint64_t part_bytes) noexcept {
  const std::lock_guard lock(mutex_);
  if (part_bytes > bytes_ - part_bytes_ - std::min(bytes_ - part_bytes_, lent_bytes_)) return false;
  part_bytes_ += part_bytes;
  ++store_count_;
  divide();
  return true;
}

void Budget::join(Borrower& store, std::uint64_t part_bytes) {
  if (process_ != ::getpid())
    throw Error(ErrorCode::kBadState,
                fmt::format("open store: the shared budget belongs to process {}, and this is "
                            "process {}, which was forked from it: make another budget here",
                            process_, ::getpid()));
  const std::lock_guard members(members_mutex_);
  with_memory_errors("open store", [&] { members_.push_back(&store); });
  if (add_part(part_bytes)) return;
  members_.pop_back();
  {
    // Stores shrink to portions beside the new part.
    const std::lock_guard lock(mutex_);
    const std::uint64_t rest = bytes_ - part_bytes_;
    portion_bytes_ =
        part_bytes > rest ? portion_bytes_.load() : (rest - part_bytes) / (store_count_ + 1);
  }
  for (Borrower* const member : members_) member->shrink();
  if (add_part(part_bytes)) {
    members_.push_back(&store);  // has room since the first one
    return;
  }
  const std::lock_guard lock(mutex_);
  divide();
  throw Error(ErrorCode::kBudget,
              fmt::format("open store: expected {} bytes of the shared budget, found {} of {}; {} "
                          "stores have parts of {} bytes, and have borrowed {} bytes",
                          part_bytes, bytes_ - part_bytes_ - lent_bytes_, bytes_, store_count_,
                          part_bytes_, lent_bytes_));
}

void Budget::leave(Borrower& store, std::uint64_t part_bytes) noexcept {
  const std::lock_guard members(members_mutex_);
  std::erase(members_, &store);
  const std::lock_guard lock(mutex_);
  part_bytes_ -= part_bytes;
  --store_count_;
  divide();
}

bool Budget::lend(std::uint64_t lent_bytes, std::uint64_t more_bytes) noexcept {
  const std::lock_guard lock(mutex_);
  if (lent_bytes + more_bytes > portion_bytes_ ||
      more_bytes > bytes_ - part_bytes_ - std::min(bytes_ - part_bytes_, lent_bytes_))
    return false;
  lent_bytes_ += more_bytes;
  return true;
}

void Budget::give_back(std::uint64_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  lent_bytes_ -= bytes;
}

PLAIT_END_NAMESPACE
