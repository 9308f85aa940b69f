// remesh/scan_progress.h: the progress of remesh(): thousandths of the whole work, from its parts.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <utility>

#include "plait/detail/namespace.h"
#include "plait/error.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A part of the whole work, in thousandths.
struct WorkPart {
  std::uint64_t first, last;

  /// Part `number` of `count` equal parts of this one.
  WorkPart nth(std::uint64_t number, std::uint64_t count) const {
    const std::uint64_t length = last - first;
    return {first + length * number / count, first + length * (number + 1) / count};
  }
  /// `inner` is a part of 1000 thousandths; the result is that part of this one.
  WorkPart of(WorkPart inner) const {
    const std::uint64_t length = last - first;
    return {first + length * inner.first / 1000, first + length * inner.last / 1000};
  }
};

class ScanProgress {
 public:
  explicit ScanProgress(ProgressCallback callback) : callback_(std::move(callback)) {}

  /// A callback for one step of the work. Empty if nobody asks for the progress.
  ProgressCallback during(WorkPart part) const {
    if (!callback_) return {};
    return [this, part](const Progress& now) {
      const std::uint64_t done =
          now.total == 0 ? 0 : (part.last - part.first) * std::min(now.done, now.total) / now.total;
      return callback_({now.phase, part.first + done, 1000});
    };
  }
  /// A step begins. Errors: kCancelled.
  void begin(std::string_view phase, std::uint64_t thousandths) const {
    if (callback_ && !callback_({phase, thousandths, 1000}))
      throw Error(ErrorCode::kCancelled, fmt::format("remesh: cancelled, {}", phase));
  }

 private:
  ProgressCallback callback_;
};

PLAIT_END_NAMESPACE
