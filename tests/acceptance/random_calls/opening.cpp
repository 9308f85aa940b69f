// Calls that open, close, drop and move stores.
#include <algorithm>
#include <utility>

#include "acceptance/random_calls/machine.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "plait/store_info.h"

namespace plait::test {

void Machine::create() {
  StoreOptions options;
  options.backend = kind_.backend;
  options.pipeline = kind_.pipeline;
  options.block_bytes = 4096;
  options.budget_bytes = budget_;
  options.durability = Durability::kNone;
  options.io_threads = io_threads_;
  options.events = listener();
  options.parallel_for = pool_;
  store_ = Store::create(on_disk() ? path() : std::filesystem::path(), base_, options,
                         default_backends());
  require(heard_->opened == 1 && heard_->last_version == 0, "the event of a new store");
  writable_ = true;
  add_base_positions(*store_);
  now_ = content_of(*store_);
  committed_ = {};
  committed_.provenance = now_.provenance;
  sequence_ = 0;
}

bool Machine::is_locked() const {
  return std::ranges::any_of(kept_, [](const Kept& kept) { return kept.holds_lock; });
}

void Machine::open(std::uint32_t how) {
  if (store_) return;
  if (!on_disk() || sequence_ == 0) {
    if (on_disk() && !kept_.empty()) return;
    guests_.clear();
    if (!on_disk()) kept_.clear();
    return create();
  }
  OpenOptions options;
  options.writable = how % 4 != 0;
  options.budget_bytes = budget_;
  options.durability = Durability::kNone;
  options.io_threads = io_threads_;
  options.events = listener();
  options.parallel_for = pool_;
  std::optional<Store> opened;
  const auto code =
      code_of_call([&] { opened = Store::open(path(), options, default_backends()); });
  if (code) {
    require(options.writable && is_locked() && *code == ErrorCode::kBusy, message_);
    return;
  }
  require(!(options.writable && is_locked()), "two writers have the store open");
  require(heard_->opened == 1 && heard_->last_version == sequence_, "the event of an open store");
  store_ = std::move(opened);
  writable_ = options.writable;
  now_ = committed_;
  now_.provenance = store_->provenance();
}

void Machine::forget_main(bool dropped) {
  for (Kept& kept : kept_) {
    if (!kept.of_main) continue;
    kept.of_main = false;
    kept.content = nullptr;
    kept.holds_lock = dropped && writable_;
  }
}

void Machine::close() {
  const auto code = code_of_call([&] { store_->close(); });
  require(readers() > 0 ? code == ErrorCode::kBusy : !code, "close: " + message_);
  if (code) return;
  require(code_of_call([&] { store_->commit(); }) == ErrorCode::kBadState,
          "a closed store commits");
  require(code_of_call([&] { Reader reader(*store_); }) == ErrorCode::kBadState,
          "a closed store has a reader");
  require(!code_of_call([&] { store_->close(); }), "a second close fails");
  heard_->is_over = true;
  store_.reset();
}

void Machine::drop() {
  if (on_disk() && sequence_ == 0 && readers() > 0) return;
  for (const Kept& kept : kept_)
    if (kept.of_main && kept.reader) check_reader(*kept.reader);
  store_.reset();
  heard_->is_over = readers() == 0;
  forget_main(true);
}

void Machine::guest() {
  if (!on_disk() || sequence_ == 0 || guests_.size() >= 2) return;
  Store opened = Store::open(path(), {}, default_backends());
  compare(opened, committed_, "a second open");
  guests_.push_back({std::move(opened), committed_});
}

void Machine::leave(std::uint32_t a) {
  if (guests_.empty()) return;
  guests_.erase(guests_.begin() + static_cast<std::ptrdiff_t>(a % guests_.size()));
}

void Machine::second_writer() {
  if (!on_disk() || sequence_ == 0 || !writable_) return;
  const auto code = code_of_call([&] {
    Store::open(path(), {.writable = true, .durability = Durability::kNone}, default_backends());
  });
  require(code == ErrorCode::kBusy, "a second writer: " + message_);
}

void Machine::gone() {
  if (!store_) return;
  Store elsewhere = std::move(*store_);
  const auto refuses = [&](const auto& call) {
    require(code_of_call(call) == ErrorCode::kBadState, "a store that was moved from works");
  };
  refuses([&] { store_->attributes(); });
  refuses([&] { store_->commit(); });
  refuses([&] { store_->info(); });
  refuses([&] { digest(*store_); });
  *store_ = std::move(elsewhere);
}

}  // namespace plait::test
