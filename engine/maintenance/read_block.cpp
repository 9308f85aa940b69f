#include "maintenance/read_block.h"

#include <array>
#include <future>
#include <utility>
#include <vector>

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

/// The attribute that a backend knows by the number that is in its block tables.
AttributeId numbered(Store& store, const ContextBlock& needed) {
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level >= needed.level &&
        store.level_file(id, needed.level).table.attribute() == needed.attribute)
      return id;
  return kNoId;
}

}  // namespace

void read_block(Store& store, AttributeId attribute, int level, std::uint64_t block,
                std::span<std::byte> into) {
  Backend& backend = *store.level_file(attribute, level).backend;
  std::array<ContextBlock, kMostContextBlocks> needed;
  const std::size_t count = backend.context(block, needed);
  if (count == 0 || backend.reads_alone(block)) return backend.read({block, 1}, into);

  Session session = store.open_session();
  std::vector<BlockRequest> requests;
  for (const ContextBlock& other : std::span(needed).first(count))
    requests.emplace_back(
        static_cast<const Store&>(store).level_file(numbered(store, other), other.level),
        other.block);
  std::vector<PinnedBlock> pinned(count);
  session.pin_many(requests, pinned);
  std::vector<std::span<const std::byte>> context;
  context.reserve(count);
  for (const PinnedBlock& other : pinned) context.push_back(other.bytes());
  Waiting waiting;
  Transfer transfer;
  transfer.block = block;
  transfer.memory = into;
  transfer.context = context;
  transfer.listener = &waiting;
  backend.start(transfer);
  waiting.wait();
}

PLAIT_END_NAMESPACE
