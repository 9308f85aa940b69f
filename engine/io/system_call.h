// Makes a system call on a file: calls the hook of io/file_operations.h around it, and repeats
// the call if a signal interrupted it.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

#include "io/file_operations.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Whether the operation makes a file longer than this process may write (RLIMIT_FSIZE).
inline bool exceeds_file_limit(const FileOperation& operation) noexcept {
  using Kind = FileOperation::Kind;
  if (operation.kind != Kind::kWrite && operation.kind != Kind::kResize &&
      operation.kind != Kind::kPreallocate)
    return false;
  rlimit limit{};
  return ::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
         operation.offset + operation.bytes > limit.rlim_cur;
}

/// `call(most_bytes)` makes the system call and returns its result: -1 with errno, or a value.
/// attempt_once() returns the same, also -1 with EINTR if a signal interrupted the call. EFBIG
/// without a call for bytes past RLIMIT_FSIZE: the kernel would send SIGXFSZ, which ends a program
/// that does not handle it.
template <class Call>
ssize_t attempt_once(FileOperation operation, Call call) noexcept {
  constexpr std::uint64_t kMaxTransferBytes = 0x7ffff000;  // Linux moves at most this much at once
  using Kind = FileOperation::Kind;
  const FileOperationHook::Verdict verdict = before_operation(operation);
  errno = verdict.error == 0 && exceeds_file_limit(operation) ? EFBIG : verdict.error;
  ssize_t result = errno != 0 ? -1 : 0;
  if (result == 0 && !verdict.pretend)
    result = call(std::min({verdict.most_bytes, operation.bytes, kMaxTransferBytes}));
  if (result >= 0) {
    if (operation.kind == Kind::kRead || operation.kind == Kind::kWrite)
      operation.bytes = static_cast<std::uint64_t>(result);
    after_operation(operation);
  }
  return result;
}

/// The same, again and again while signals interrupt the call. For calls that go on where they
/// were, or that do not sleep.
template <class Call>
ssize_t attempt(const FileOperation& operation, Call call) noexcept {
  while (true)
    if (const ssize_t result = attempt_once(operation, call); result >= 0 || errno != EINTR)
      return result;
}

PLAIT_END_NAMESPACE
