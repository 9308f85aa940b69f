// compressed/codec_time.h: how long this process has encoded and decoded blocks, for programs
// that tell where their time went.
#pragma once

#include <chrono>
#include <cstdint>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Nanoseconds that the threads of this process have spent in the filters and codecs of compressed
/// stores so far, for all stores together. The times of threads are added up, so the sum may grow
/// faster than the clock. Reading and writing the encoded bytes is not in it. It counts for the
/// process, as getrusage() does: take the difference between two calls. Safe from any thread.
/// Pinned by tests/backends/compressed/compressed_backend_test.cpp.
std::uint64_t codec_nanoseconds() noexcept;

PLAIT_END_NAMESPACE

PLAIT_BEGIN_PRIVATE_NAMESPACE

// Counts the time of one block in filters and codecs.

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
