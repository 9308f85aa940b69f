#include "io/copy_range.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <span>
#include <vector>

#include "io/system_call.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Kind = FileOperation::Kind;

/// Whether reading and writing would fail with the same error. Kernels, file systems and filters of
/// system calls refuse copy_file_range() with many others: EXDEV, EINVAL, EPERM, EIO, ETXTBSY.
bool is_of_writing(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

void copy_through_memory(const File& from, File& to, std::uint64_t offset, std::uint64_t bytes) {
  constexpr std::uint64_t kPartBytes = 1 << 20;
  std::vector<std::byte> buffer(std::min(bytes, kPartBytes));
  for (std::uint64_t done = 0; done < bytes;) {
    const std::span<std::byte> part = std::span(buffer).first(std::min(kPartBytes, bytes - done));
    from.read_at(offset + done, part);
    to.write_at(offset + done, part);
    done += part.size();
  }
}

}  // namespace

void copy_range(const File& from, File& to, std::uint64_t offset, std::uint64_t bytes) {
  while (bytes > 0) {
    const ssize_t readable =
        attempt({Kind::kRead, from.path(), offset, bytes},
                [](std::uint64_t most_bytes) { return static_cast<ssize_t>(most_bytes); });
    if (readable < 0) throw system_error("read", from.path().native(), errno, offset);
    const FileOperation writing{Kind::kWrite, to.path(), offset,
                                static_cast<std::uint64_t>(readable)};
    bool called = false;
    const ssize_t copied = attempt(writing, [&](std::uint64_t most_bytes) {
      called = true;
      auto begin = static_cast<off_t>(offset), end = begin;
      return ::copy_file_range(from.descriptor(), &begin, to.descriptor(), &end, most_bytes, 0);
    });
    // Also where nothing is copied: some kernels do that, and a file that ends is noticed there.
    if (called && (copied == 0 || (copied < 0 && !is_of_writing(errno))))
      return copy_through_memory(from, to, offset, bytes);
    if (copied < 0) throw system_error("copy to", to.path().native(), errno);
    offset += static_cast<std::uint64_t>(copied);
    bytes -= static_cast<std::uint64_t>(copied);
  }
}

void link_file(const Directory& directory, const std::string& name, const Directory& other) {
  const std::filesystem::path path = other.path_of(name);
  if (attempt({Kind::kCreate, path}, [&](auto) {
        return ::linkat(directory.descriptor(), name.c_str(), other.descriptor(), name.c_str(), 0);
      }) >= 0)
    return;
  if (errno == EPERM || errno == ENOSYS || errno == ENOTSUP)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("create {}: its file system has no hard links", path.native()))
        .about(path);
  throw system_error("create", path.native(), errno);
}

PLAIT_END_NAMESPACE
