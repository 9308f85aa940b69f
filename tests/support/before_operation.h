// tests/support/before_operation.h: what another process does at the worst moment.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <utility>

#include "io/file_operations.h"

namespace plait::test {

/// Does `work` once, right before the first operation of this kind on a file of this name. While
/// the object lives it is the process's hook.
class BeforeOperation final : public FileOperationHook {
 public:
  BeforeOperation(FileOperation::Kind kind, std::string name, std::function<void()> work)
      : kind_(kind), name_(std::move(name)), work_(std::move(work)) {
    set_file_operation_hook(this);
  }
  ~BeforeOperation() { set_file_operation_hook(nullptr); }
  BeforeOperation(const BeforeOperation&) = delete;
  BeforeOperation& operator=(const BeforeOperation&) = delete;

  Verdict before(const FileOperation& operation) noexcept override {
    if (operation.kind == kind_ && operation.path.filename() == name_ && !was_done_.exchange(true))
      work_();
    return {};
  }
  void after(const FileOperation&) noexcept override {}
  bool was_done() const { return was_done_; }

 private:
  const FileOperation::Kind kind_;
  const std::string name_;
  const std::function<void()> work_;
  std::atomic<bool> was_done_ = false;
};

}  // namespace plait::test
