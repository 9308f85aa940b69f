// Makes a system call on a file: calls the hook of io/file_operations.h around it, and repeats
// the call if a signal interrupted it.
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>

#include "io/file_operations.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// `call(most_bytes)` makes the system call and returns its result: -1 with errno, or a value.
/// attempt() returns the same.
template <class Call>
ssize_t attempt(FileOperation operation, Call call) noexcept {
  constexpr std::uint64_t kMaxTransferBytes = 0x7ffff000;  // Linux moves at most this much at once
  using Kind = FileOperation::Kind;
  while (true) {
    const FileOperationHook::Verdict verdict = before_operation(operation);
    errno = verdict.error;
    ssize_t result = verdict.error != 0 ? -1 : 0;
    if (result == 0 && !verdict.pretend)
      result = call(std::min({verdict.most_bytes, operation.bytes, kMaxTransferBytes}));
    if (result < 0 && errno == EINTR) continue;
    if (result >= 0) {
      if (operation.kind == Kind::kRead || operation.kind == Kind::kWrite)
        operation.bytes = static_cast<std::uint64_t>(result);
      after_operation(operation);
    }
    return result;
  }
}

PLAIT_END_NAMESPACE
