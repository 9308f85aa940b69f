// io/file_operations.h: a hook that every file operation of a store calls. Only tests install
// one. With it they make an operation fail or transfer fewer bytes, and they record which writes a
// power cut would lose. plait maps files for reading only, so the hook sees every change of a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// A file operation that is about to begin, or has ended.
struct FileOperation {
  enum class Kind : std::uint8_t {
    kOpen,
    kCreate,
    kRead,
    kWrite,
    kResize,
    kPreallocate,
    kMap,
    kSync,
    kClose,
    kLock,
    kRemove,    ///< of a file or an empty directory
    kRename,    ///< an entry that had the name `to` before is removed
    kExchange,  ///< of two names, in one directory or in two
    kMakeDirectory,
    kSyncDirectory,
  };
  Kind kind = Kind::kOpen;
  const std::filesystem::path& path;
  std::uint64_t offset = 0,
                bytes = 0;  ///< of a read or write; of a resize, `bytes` is the new size
  const std::filesystem::path* to = nullptr;  ///< of a rename or an exchange
};

/// Whether the operation changes nothing on the disk.
constexpr bool is_harmless(FileOperation::Kind kind) {
  using Kind = FileOperation::Kind;
  return kind == Kind::kOpen || kind == Kind::kRead || kind == Kind::kMap || kind == Kind::kClose ||
         kind == Kind::kLock;
}

/// Several threads may call a hook at the same time.
class FileOperationHook {
 public:
  /// What the hook decides about an operation before it begins.
  struct Verdict {
    int error = 0;  ///< an errno value: the operation is skipped and fails with this error
    std::uint64_t most_bytes = std::numeric_limits<std::uint64_t>::max();  ///< of a read or write
    bool pretend = false;  ///< of a sync: the call is skipped and reported as a success
  };
  virtual Verdict before(const FileOperation& operation) noexcept = 0;
  /// The operation succeeded; reads and writes moved `operation.bytes` bytes.
  virtual void after(const FileOperation& operation) noexcept = 0;

 protected:
  ~FileOperationHook() = default;
};

/// Installs the hook of the whole process; nullptr, the initial value, means no hook. The hook must
/// outlive every file operation that begins before the next call of this function.
void set_file_operation_hook(FileOperationHook* hook) noexcept;
FileOperationHook* file_operation_hook() noexcept;

/// Calls the hook. Without a hook, the verdict allows the operation.
FileOperationHook::Verdict before_operation(const FileOperation& operation) noexcept;
void after_operation(const FileOperation& operation) noexcept;

PLAIT_END_NAMESPACE
