// tests/support/answering_operations.h: a kernel or a file system that answers one kind of
// operation in its own way.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

#include "io/file_operations.h"

namespace plait::test {

/// The process's hook while it exists. `answer` gives the errno with which an operation fails; 0
/// lets it go on.
class AnsweringOperations final : public FileOperationHook {
 public:
  explicit AnsweringOperations(std::function<int(const FileOperation&)> answer)
      : answer_(std::move(answer)) {
    set_file_operation_hook(this);
  }
  AnsweringOperations(FileOperation::Kind kind, int error)
      : AnsweringOperations(
            [=](const FileOperation& operation) { return operation.kind == kind ? error : 0; }) {}
  ~AnsweringOperations() { set_file_operation_hook(nullptr); }
  AnsweringOperations(const AnsweringOperations&) = delete;
  AnsweringOperations& operator=(const AnsweringOperations&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    const int error = answer_(operation);
    if (error != 0) ++answers_;
    return {.error = error};
  }
  void after(const FileOperation&) noexcept override {}
  std::uint64_t answers() const { return answers_; }

 private:
  std::function<int(const FileOperation&)> answer_;
  std::atomic<std::uint64_t> answers_ = 0;
};

}  // namespace plait::test
