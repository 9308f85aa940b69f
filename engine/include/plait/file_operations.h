// plait/file_operations.h: the seam under every file operation of a store. Tests stand in it to
// make an operation fail or fall short, and to note what a power cut would leave; nobody else does.
// Files are mapped for reading only, so that every change of a file passes the seam.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>

namespace plait {

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
    kRename,    ///< what had the name `to` is gone
    kExchange,  ///< two names of one directory or two
    kMakeDirectory,
    kSyncDirectory,
  };
  Kind kind = Kind::kOpen;
  const std::filesystem::path& path;
  std::uint64_t offset = 0, bytes = 0;        ///< of reads and writes; of a resize the new size
  const std::filesystem::path* to = nullptr;  ///< of a rename or an exchange
};

/// Whether the operation leaves what is on the disk as it is.
constexpr bool is_harmless(FileOperation::Kind kind) {
  using Kind = FileOperation::Kind;
  return kind == Kind::kOpen || kind == Kind::kRead || kind == Kind::kMap || kind == Kind::kClose ||
         kind == Kind::kLock;
}

/// Is asked from any thread, several at once.
class FileOperationHook {
 public:
  struct Verdict {
    int error = 0;  ///< an errno: the operation is not begun, and fails so
    std::uint64_t most_bytes = std::numeric_limits<std::uint64_t>::max();  ///< of a read or write
    bool pretend = false;  ///< of a sync: it counts as done, and is not made
  };
  virtual Verdict before(const FileOperation& operation) noexcept = 0;
  /// The operation succeeded; reads and writes moved `operation.bytes` bytes.
  virtual void after(const FileOperation& operation) noexcept = 0;

 protected:
  ~FileOperationHook() = default;
};

/// For the whole process; nullptr, as it is at first, for none. The hook must outlive every file
/// operation that begins before the next call.
void set_file_operation_hook(FileOperationHook* hook) noexcept;
FileOperationHook* file_operation_hook() noexcept;

/// What the hook says of it; everything is allowed where there is none.
FileOperationHook::Verdict before_operation(const FileOperation& operation) noexcept;
void after_operation(const FileOperation& operation) noexcept;

}  // namespace plait
