#include "plait/extend/backend.h"

#include "base/caught.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void Backend::start(Transfer& transfer) noexcept {
  std::exception_ptr error;
  try {
    if (transfer.direction == Transfer::Direction::kRead)
      read({transfer.block, 1}, transfer.memory);
    else
      write({transfer.block, 1}, transfer.memory);
  } catch (...) {
    error = caught_exception();
  }
  transfer.listener->finished(transfer, error);
}

void Backend::start_run(std::span<Transfer* const> run) noexcept {
  for (Transfer* const transfer : run) start(*transfer);
}

PLAIT_END_NAMESPACE
