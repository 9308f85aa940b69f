// plait/error.h: the one exception type of the library.
//
// A message names, in this order: the verb, the file, the place in it (byte offset, line or
// element), what was expected and what was found. Each layer adds its noun once.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class ErrorCode : std::uint8_t {
  kNotFound,         ///< a file, store, attribute or level does not exist
  kInvalidArgument,  ///< an argument out of its range, or a refused input file
  kCorruption,       ///< stored bytes that fail their checksum or contradict each other
  kNotSupported,     ///< a backend, codec or feature that this build or machine lacks
  kIo,               ///< the operating system refused a file operation
  kNoSpace,          ///< the disk or the quota is full
  kOutOfMemory,      ///< an allocation failed
  kBudget,           ///< the memory budget is too small; the message says how much is enough
  kBusy,             ///< another process has the store open
  kBadState,         ///< a call that the object's state forbids
  kCancelled,        ///< the caller cancelled the work
};

/// The name of a code in messages and JSON ("not_found", "no_space", ...).
std::string_view to_string(ErrorCode code) noexcept;

/// The exception of the library: a code for programs, and a message of one line for people.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const noexcept { return code_; }

 private:
  ErrorCode code_;
};

/// An Error from `errno_value`: ENOSPC and EDQUOT become kNoSpace, ENOENT becomes kNotFound, ENOMEM
/// becomes kOutOfMemory, all other values become kIo. The message is "VERB PATH: TEXT OF ERRNO".
Error system_error(std::string_view verb, std::string_view path, int errno_value);

PLAIT_END_NAMESPACE
