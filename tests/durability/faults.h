// tests/durability/faults.h: file operations that fail, fall short or are interrupted.
#pragma once

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "io/file_operations.h"

namespace plait::test {

/// Nothing here outlives the test: what a disk would do is played, not waited for.
inline FileOperationHook::Verdict without_waiting(const FileOperation& operation) noexcept {
  FileOperationHook::Verdict verdict;
  verdict.pretend = operation.kind == FileOperation::Kind::kSync ||
                    operation.kind == FileOperation::Kind::kSyncDirectory;
  return verdict;
}

/// While it lives it is the process's hook, and lets no sync reach the disk.
class NoWaiting final : public FileOperationHook {
 public:
  NoWaiting() { set_file_operation_hook(this); }
  ~NoWaiting() { set_file_operation_hook(nullptr); }
  NoWaiting(const NoWaiting&) = delete;
  NoWaiting& operator=(const NoWaiting&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    return without_waiting(operation);
  }
  void after(const FileOperation&) noexcept override {}
};

/// Counts the operations below `root`, and lets one of them fail, or it and all after it. While it
/// lives it is the process's hook.
class FailingOperations final : public FileOperationHook {
 public:
  enum class From : std::uint8_t { kOne, kAllFromThere };

  /// Operation `failing` (from 0) fails with `error`, an errno.
  FailingOperations(std::filesystem::path root, std::uint64_t failing, int error, From from)
      : root_(std::move(root)), failing_(failing), error_(error), from_(from) {
    set_file_operation_hook(this);
  }
  ~FailingOperations() { set_file_operation_hook(nullptr); }
  FailingOperations(const FailingOperations&) = delete;
  FailingOperations& operator=(const FailingOperations&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    if (!operation.path.native().starts_with(root_.native())) return {};
    const std::uint64_t number = count_++;
    const bool fails = from_ == From::kOne ? number == failing_ : number >= failing_;
    return fails ? Verdict{error_} : without_waiting(operation);
  }
  void after(const FileOperation&) noexcept override {}

  bool failed() const { return count_ > failing_; }

 private:
  std::filesystem::path root_;
  std::uint64_t failing_;
  int error_;
  From from_;
  std::atomic<std::uint64_t> count_{0};
};

/// Every transfer moves at most `most_bytes`, and every operation is interrupted once before.
class ShortAndInterrupted final : public FileOperationHook {
 public:
  explicit ShortAndInterrupted(std::uint64_t most_bytes) : most_bytes_(most_bytes) {
    set_file_operation_hook(this);
  }
  ~ShortAndInterrupted() { set_file_operation_hook(nullptr); }
  ShortAndInterrupted(const ShortAndInterrupted&) = delete;
  ShortAndInterrupted& operator=(const ShortAndInterrupted&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    thread_local bool interrupted = false;
    interrupted = !interrupted && operation.kind != FileOperation::Kind::kMap &&
                  operation.kind != FileOperation::Kind::kClose;
    ++operations_;
    if (interrupted) return {EINTR};
    Verdict verdict = without_waiting(operation);
    verdict.most_bytes = most_bytes_;
    return verdict;
  }
  void after(const FileOperation&) noexcept override {}

  std::uint64_t operations() const { return operations_; }

 private:
  std::uint64_t most_bytes_;
  std::atomic<std::uint64_t> operations_{0};
};

}  // namespace plait::test
