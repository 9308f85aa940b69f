// plait/extend/parallel_for.h: how a program lets plait compute on threads of its own.
#pragma once

#include <functional>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A parallel loop of the program's thread pool: calls body(0) to body(count - 1), each once, and
/// returns when all have returned. It may call them in any order and on any number of threads, one
/// included, and the calling thread may be one of them. The results do not depend on that.
///
/// - No body waits for one that has not begun. It may wait for one that has: so each begun body
///   has a thread to itself until it returns, and that thread does not begin another one inside it.
/// - No body throws. The call for which plait computes throws what a body found.
/// - `body` is valid until this function returns. All that bodies wrote must be visible then, as it
///   is after any join.
/// - If this function throws, no body may run any more. What it throws comes out of the call.
///
/// A function that calls a body twice, or leaves one out without an error, makes the call fail with
/// kBadState.
using ParallelFor = std::function<void(int count, const std::function<void(int)>& body)>;

PLAIT_END_NAMESPACE
