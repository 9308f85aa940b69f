#include "plait/backends/choose_backend.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr const char* kUring = "uring";
constexpr const char* kPread = "pread";

std::string mebibytes(std::uint64_t bytes) { return fmt::format("{} MiB", bytes >> 20); }

/// The reason why the kernel refuses uring; empty if it does not.
std::string kernel_refusal(const BackendRegistry& backends) {
  try {
    const BackendRegistry::Entry& uring = backends.find(kUring);
    if (uring.validate) uring.validate({});
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

/// The reason why files in `directory` cannot be opened with O_DIRECT; empty if they can. To find
/// out, the function opens a temporary file that has no name.
std::string file_system_refusal(const std::filesystem::path& directory) {
  struct statfs status {};
  if (::statfs(directory.c_str(), &status) == 0 &&
      (status.f_type == TMPFS_MAGIC || status.f_type == RAMFS_MAGIC))
    return "its file system keeps files in memory";
  const int file =
      ::open(directory.c_str(), O_TMPFILE | O_RDWR | O_DIRECT | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0)
    return fmt::format("its file system has no O_DIRECT ({})",
                       std::generic_category().message(errno));
  ::close(file);
  return {};
}

}  // namespace

BackendChoice choose_backend(const BackendRegistry& backends, const std::filesystem::path& path,
                             std::uint64_t raw_bytes, std::uint64_t available_bytes) {
  const std::string sizes = fmt::format("{} of levels, {} of memory available",
                                        mebibytes(raw_bytes), mebibytes(available_bytes));
  if (raw_bytes <= available_bytes / kLargeStoreDivisor)
    return {kPread, fmt::format("the store is small compared with the memory: {}", sizes)};
  if (const std::string refusal = kernel_refusal(backends); !refusal.empty())
    return {kPread, fmt::format("the store is large compared with the memory ({}), but {}", sizes,
                                refusal)};
  const std::filesystem::path directory = path.parent_path().empty() ? "." : path.parent_path();
  if (const std::string refusal = file_system_refusal(directory); !refusal.empty())
    return {kPread, fmt::format("the store is large compared with the memory ({}), but {}", sizes,
                                refusal)};
  return {kUring, fmt::format("the store is large compared with the memory: {}", sizes)};
}

PLAIT_END_NAMESPACE
