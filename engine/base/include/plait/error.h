// plait/error.h: the one exception type of the library.
//
// A message names, in this order: the verb, the file, the place in it (byte offset, line or
// element), what was expected and what was found. Each layer adds its noun once. The file and the
// offset are members too, so that a program need not read them from the text.
//
// Memory that runs out is an Error with kOutOfMemory in every call that takes memory for meshes,
// blocks or records: of BaseMesh, Store, Session and Reader, the executors, the kernels, jobs, and
// maintenance. Calls that only look something up may throw std::bad_alloc.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "plait/detail/namespace.h"

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

/// The exception of the library: a code for programs, and a message of one line for people. Copies
/// share their place, so copying never fails.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  /// The same error with another message.
  Error(const Error& error, const std::string& message)
      : std::runtime_error(message), code_(error.code_), place_(error.place_) {}

  ErrorCode code() const noexcept { return code_; }
  /// The file or directory that the error is about; empty if it is about none.
  const std::filesystem::path& path() const noexcept;
  /// The byte of the file that the error is about, if it is about one.
  std::optional<std::uint64_t> offset() const noexcept;

  /// This error, about a file: throw Error(code, message).about(path).
  Error about(const std::filesystem::path& file, std::optional<std::uint64_t> offset = {}) const;

 private:
  struct FilePlace {
    std::filesystem::path path;
    std::optional<std::uint64_t> offset;
  };
  ErrorCode code_;
  std::shared_ptr<const FilePlace> place_;
};

/// "VERB: expected enough memory, found too little".
Error out_of_memory(std::string_view verb);

/// Calls work() and returns its result. Memory that runs out becomes kOutOfMemory: "VERB: ...".
template <class Work>
decltype(auto) with_memory_errors(std::string_view verb, Work&& work) try {
  return std::forward<Work>(work)();
} catch (const std::bad_alloc&) {
  throw out_of_memory(verb);
} catch (const std::length_error&) {  // a count that no memory could have
  throw out_of_memory(verb);
}

/// An Error from `errno_value`: ENOSPC and EDQUOT become kNoSpace, ENOENT becomes kNotFound, ENOMEM
/// becomes kOutOfMemory, all other values become kIo. The message is "VERB PATH: TEXT OF ERRNO",
/// and the error is about this path and offset.
Error system_error(std::string_view verb, std::string_view path, int errno_value,
                   std::optional<std::uint64_t> offset = {});

PLAIT_END_NAMESPACE
