// backends/compressed/codec_timer.h: counts the time of one block in filters and codecs.
#pragma once

#include <chrono>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Adds the time of its life to codec_nanoseconds(). One for a block, so two looks at the clock.
class CodecTimer {
 public:
  CodecTimer() noexcept : start_(std::chrono::steady_clock::now()) {}
  ~CodecTimer();
  CodecTimer(const CodecTimer&) = delete;
  CodecTimer& operator=(const CodecTimer&) = delete;

 private:
  std::chrono::steady_clock::time_point start_;
};

PLAIT_END_NAMESPACE
