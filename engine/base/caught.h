// base/caught.h: what a handler of all exceptions, catch (...), does first.
//
// pthread_exit(), pthread_cancel() and the end of an interpreter unwind the stack of a thread as an
// exception does, and catch (...) catches this forced unwind. A handler that does not throw it
// again ends the process. So a handler of all exceptions throws again, or takes the exception by
// one of these functions.
#pragma once

#include <exception>

#include "plait/detail/namespace.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The exception that is being handled. A forced unwind goes on from here. REQUIRES: in a handler.
inline std::exception_ptr caught_exception() {
  std::exception_ptr caught = std::current_exception();
  if (!caught) throw;  // it is an exception of no language
  return caught;
}

/// The same for a thread that does a part of a work: stores the exception in `first`, unless that
/// has one. A forced unwind goes on, and `first` then has kCancelled: a part of the work is
/// missing. REQUIRES: in a handler; the caller has the lock of `first`.
inline void keep_first(std::exception_ptr& first) {
  const std::exception_ptr caught = std::current_exception();
  if (!first)
    first = caught ? caught
                   : std::make_exception_ptr(
                         Error(ErrorCode::kCancelled, "a thread of the work was ended in a call"));
  if (!caught) throw;
}

PLAIT_END_NAMESPACE
