// plait/progress.h: how a program watches and cancels a long call.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// How far a call is.
struct Progress {
  std::string_view phase = {};  ///< "level 3: odd vertices"; valid during the callback
  /// Of the whole call, unless its comment says otherwise. The call's comment names their unit.
  std::uint64_t done = 0, total = 0;
};

/// A call with such a callback calls it many times, on the thread that made the call, or, if the
/// store has a parallel_for (plait/options.h), on one of its threads at a time. If it returns
/// false, the call ends with ErrorCode::kCancelled. It may be empty.
using ProgressCallback = std::function<bool(const Progress&)>;

PLAIT_END_NAMESPACE
