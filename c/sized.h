// sized.h: structures whose first member is their size. A program and the library may have been
// built with different versions of plait.h, so either of the two may know fewer members.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "guard.h"

namespace plait::c {

/// Throws kInvalidArgument unless `given` has between `smallest` and `known` bytes, or more bytes
/// that are all zero beyond `known`: such a member has a meaning that this library does not know.
void check_size(const void* given, std::size_t smallest, std::size_t known);

/// The options that a program has given, with `defaults` for the members that it does not know.
/// `smallest` is the size of the structure in the first version of the interface.
template <class Options>
Options options_of(const Options* given, const Options& defaults,
                   std::size_t smallest = sizeof(Options)) {
  if (given == nullptr) return defaults;
  check_size(given, smallest, sizeof(Options));
  Options options = defaults;
  std::memcpy(&options, given, std::min(given->struct_size, sizeof(Options)));
  options.struct_size = sizeof(Options);
  return options;
}

/// Checks a structure that the library fills.
template <class Result>
void check_result(const Result* into, const char* argument, std::size_t smallest = sizeof(Result)) {
  check_given(into, argument);
  check_size(into, smallest, sizeof(Result));
}

/// Fills the members that the program knows. REQUIRES: check_result() has accepted `into`.
template <class Result>
void fill(Result* into, Result result) {
  const std::size_t size = into->struct_size;
  result.struct_size = size;
  std::memcpy(into, &result, std::min(size, sizeof(Result)));
}

}  // namespace plait::c
