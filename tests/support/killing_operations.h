// tests/support/killing_operations.h: a process that ends between two file operations.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <stdexcept>

#include "io/file_operations.h"

namespace plait::test {

/// Ends the process, as a kill would, before operation `last` (from 0) begins.
class KillingOperations final : public FileOperationHook {
 public:
  /// `exchange_error`: an errno with which every exchange of names fails.
  explicit KillingOperations(std::uint64_t last, int exchange_error = 0)
      : last_(last), exchange_error_(exchange_error) {}

  Verdict before(const FileOperation& operation) noexcept override {
    if (count_++ == last_) ::_exit(kKilled);
    return {.error = operation.kind == FileOperation::Kind::kExchange ? exchange_error_ : 0};
  }
  void after(const FileOperation&) noexcept override {}

  static constexpr int kDone = 0, kFailed = 1, kKilled = 2;

 private:
  std::uint64_t last_;
  int exchange_error_;
  std::atomic<std::uint64_t> count_{0};
};

/// Does `work` in a child process that is killed before file operation `last`; whether the child
/// was killed, false if it came to the end before. Throws if `work` did.
template <class Work>
bool run_and_kill_before(std::uint64_t last, Work work, int exchange_error = 0) {
  const pid_t child = ::fork();
  if (child == 0) {
    int status = KillingOperations::kDone;
    try {
      KillingOperations hook(last, exchange_error);
      set_file_operation_hook(&hook);
      work();
      set_file_operation_hook(nullptr);
    } catch (const std::exception&) {
      status = KillingOperations::kFailed;
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) == KillingOperations::kFailed)
    throw std::runtime_error("the child process failed");
  return WEXITSTATUS(status) == KillingOperations::kKilled;
}

}  // namespace plait::test
