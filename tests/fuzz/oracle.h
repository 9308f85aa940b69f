// tests/fuzz/oracle.h: what every target asks of the code under it.
//
// An exception that is no plait::Error ends the program, std::bad_alloc included: so does an Error
// of a code that the call does not promise.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "plait/error.h"

namespace plait::fuzz {

/// Ends the program where a relation that must hold does not.
inline void require(bool right) {
  if (!right) __builtin_trap();
}

/// A message goes to terminals and logs as one line, whatever the bytes that it speaks of.
inline bool is_one_short_line(std::string_view message) {
  return message.size() < 1000 &&
         std::all_of(message.begin(), message.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

/// Whether `call` returned; else it threw an Error of one of `codes`.
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
