// guard.h: turns exceptions into status codes, and checks what a C program passes.
#pragma once

#include <pthread.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "plait.h"
#include "plait/error.h"

namespace plait::c {

/// The code and the message of the exception that is being handled. Keeps the message for
/// plait_error_message(). A forced unwind goes on.
plait_status keep_current_error(const char* call);

/// While this object exists, pthread_cancel() of the thread waits.
class NoCancellation {
 public:
  NoCancellation() noexcept { ::pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &before_); }
  ~NoCancellation() { ::pthread_setcancelstate(before_, nullptr); }
  NoCancellation(const NoCancellation&) = delete;
  NoCancellation& operator=(const NoCancellation&) = delete;

 private:
  int before_ = PTHREAD_CANCEL_ENABLE;
};

/// Runs the body of a call of the C interface. No exception passes it, but a forced unwind does: a
/// callback may call pthread_exit(), as an interpreter does that ends. No call is a cancellation
/// point.
template <class Body>
plait_status guarded(const char* call, const Body& body) {
  const NoCancellation whole;
  try {
    body();
    return PLAIT_OK;
  } catch (...) {
    return keep_current_error(call);
  }
}

/// Throws kInvalidArgument: the argument is NULL.
[[noreturn]] void refuse_null(const char* argument);
template <class Pointer>
void check_given(Pointer pointer, const char* argument) {
  if (pointer == nullptr) refuse_null(argument);
}

/// Throws kInvalidArgument unless `found` is below `count`.
void check_choice(const char* what, std::int32_t found, std::int32_t count);
/// Throws kInvalidArgument unless a member that has no meaning yet is 0.
void check_reserved(std::int32_t found);

/// The text, or `otherwise` for NULL.
inline std::string text_or(const char* text, std::string_view otherwise) {
  return std::string(text == nullptr ? otherwise : std::string_view(text));
}

/// Throws kCancelled: a callback has returned 0.
[[noreturn]] void refuse_cancelled(const char* what);

/// Throws the error of a callback that has returned `status`, with plait_error_message() if a call
/// of the library set it.
[[noreturn]] void throw_failed(const char* what, plait_status status);

}  // namespace plait::c
