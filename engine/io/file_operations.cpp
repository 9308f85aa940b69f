#include "io/file_operations.h"

#include <atomic>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

std::atomic<FileOperationHook*> known_hook{nullptr};

}  // namespace

void set_file_operation_hook(FileOperationHook* hook) noexcept { known_hook = hook; }

FileOperationHook* file_operation_hook() noexcept {
  return known_hook.load(std::memory_order_acquire);
}

FileOperationHook::Verdict before_operation(const FileOperation& operation) noexcept {
  FileOperationHook* const hook = file_operation_hook();
  return hook ? hook->before(operation) : FileOperationHook::Verdict();
}

void after_operation(const FileOperation& operation) noexcept {
  if (FileOperationHook* const hook = file_operation_hook()) hook->after(operation);
}

PLAIT_END_NAMESPACE
