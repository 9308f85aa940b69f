// tests/fuzz/oracle.h: the checks that all targets share.
//
// An exception other than plait::Error ends the program, also std::bad_alloc. So does an Error with
// a code that the call does not document.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "plait/error.h"

namespace plait::fuzz {

/// Ends the program if `right` is false.
inline void require(bool right) {
  if (!right) __builtin_trap();
}

/// Terminals and logs show a message as one line, so it must be one, whatever bytes it quotes.
inline bool is_one_short_line(std::string_view message) {
  return message.size() < 1000 &&
         std::all_of(message.begin(), message.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// Returns true if `call` returned, and false if it threw an Error with one of `codes`. Any other
/// exception ends the program.
template <class Call>
bool accepts(std::initializer_list<ErrorCode> codes, Call call) {
  try {
    call();
    return true;
  } catch (const Error& error) {
    require(std::find(codes.begin(), codes.end(), error.code()) != codes.end());
    require(is_one_short_line(error.what()));
    return false;
  }
}

}  // namespace plait::fuzz
