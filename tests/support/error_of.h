// tests/support/error_of.h: the error of a call that must fail.
#pragma once

#include <catch2/catch.hpp>

#include "plait/error.h"

namespace plait::test {

/// The Error that `call` throws; fails the case if `call` throws none. To be called in the thread
/// of the case, because Catch2 counts failures of this thread only.
template <class Call>
Error error_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  FAIL("expected an error");
  return {ErrorCode::kBadState, ""};
}

/// The code of the Error that `call` throws; kCancelled if `call` throws none. From any thread.
template <class Call>
ErrorCode code_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::kCancelled;
}

}  // namespace plait::test
