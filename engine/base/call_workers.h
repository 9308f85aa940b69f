// base/call_workers.h: calls the workers of a pass on threads of the program's own.
#pragma once

#include <functional>
#include <string_view>

#include "plait/extend/parallel_for.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Calls work(0) to work(count - 1) by `parallel_for`, and throws the first exception of any of
/// them. Workers take what they do from a queue, so it does not matter how many threads there are.
/// `name` begins the message. Errors: also kBadState unless `parallel_for` keeps its promise.
void call_workers(const ParallelFor& parallel_for, int count, std::string_view name,
                  const std::function<void(int)>& work);

PLAIT_END_NAMESPACE
