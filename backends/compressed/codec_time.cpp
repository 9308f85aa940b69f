#include "compressed/codec_time.h"

#include <atomic>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::atomic<std::uint64_t> all_nanoseconds{0};

}  // namespace

CodecTimer::~CodecTimer() {
  const auto passed = std::chrono::nanoseconds(std::chrono::steady_clock::now() - start_);
  all_nanoseconds.fetch_add(static_cast<std::uint64_t>(passed.count()), std::memory_order_relaxed);
}

std::uint64_t codec_nanoseconds() noexcept {
  return all_nanoseconds.load(std::memory_order_relaxed);
}

PLAIT_END_NAMESPACE
