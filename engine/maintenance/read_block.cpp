#include "maintenance/read_block.h"

#include <algorithm>
#include <array>
#include <future>
#include <utility>
#include <vector>

#include "paging/frame_pool.h"
#include "plait/extend/pager.h"
#include "plait/extend/store_access.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class Waiting final : public TransferListener {
 public:
  void finished(Transfer&, std::exception_ptr error) noexcept override {
    if (error)
      done_.set_exception(std::move(error));
    else
      done_.set_value();
  }
  void wait() { done_.get_future().get(); }

 private:
  std::promise<void> done_;
};

/// Finds the attribute whose block tables have this number.
AttributeId numbered(const Store& store, const ContextBlock& needed) {
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level >= needed.level &&
        StoreAccess::level_file(store, id, needed.level).table.attribute() == needed.attribute)
      return id;
  return kNoId;
}

}  // namespace

PinnedContext::PinnedContext(const Store& store, std::span<const ContextBlock> needed)
    : session_(StoreAccess::open_session(store)), pinned_(needed.size()) {
  std::vector<BlockRequest> requests;
  for (const ContextBlock& block : needed)
    requests.emplace_back(StoreAccess::level_file(store, block.attribute, block.level),
                          block.block);
  session_.pin_many(requests, pinned_);
  for (const PinnedBlock& block : pinned_) bytes_.push_back(block.bytes());
}

void read_block(const Store& store, AttributeId attribute, int level, std::uint64_t block,
                std::span<std::byte> into) {
  Backend& backend = *StoreAccess::level_file(store, attribute, level).backend;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = backend.read_context(block, needed);
  if (count == 0) return backend.read({block, 1}, into);

  for (ContextBlock& other : std::span(needed).first(count))
    other.attribute = numbered(store, other);
  const PinnedContext context(store, std::span(needed).first(count));
  Waiting waiting;
  Transfer transfer;
  transfer.block = block;
  transfer.memory = into;
  transfer.context = context.bytes();
  transfer.listener = &waiting;
  backend.start(transfer);
  waiting.wait();
}

Session open_source_session(const Store& store, const LevelFile& level) {
  if (needs_other_blocks(level)) return StoreAccess::open_session(store);
  constexpr std::uint64_t kBlocks = Pager::kInFlight + 2;  // one is pinned, one was before
  const std::uint64_t frame_bytes = FramePool::frame_bytes(level.geometry.max_block_bytes());
  const std::uint64_t half = StoreAccess::pager(store).budget_bytes() / 2;
  return StoreAccess::open_session(store, {.share_bytes = std::min(kBlocks * frame_bytes, half)});
}

PLAIT_END_NAMESPACE
