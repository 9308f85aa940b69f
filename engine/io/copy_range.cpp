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

/// Whether the system cannot copy between these two files: they are on different file systems, or
/// the kernel is old.
bool must_pass_through_memory(int error) {
  return error == EXDEV || error == EINVAL || error == ENOSYS || error == EOPNOTSUPP ||
         error == EBADF;
}

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
    const ssize_t copied = attempt(writing, [&](std::uint64_t most_bytes) {
      auto begin = static_cast<off_t>(offset), end = begin;
      return ::copy_file_range(from.descriptor(), &begin, to.descriptor(), &end, most_bytes, 0);
    });
    if (copied < 0 && must_pass_through_memory(errno))
      return copy_through_memory(from, to, offset, bytes);
    if (copied < 0) throw system_error("copy to", to.path().native(), errno);
    if (copied == 0)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("read {}: the file ends at byte {}, expected {} more bytes there",
                              from.path().native(), offset, bytes))
          .about(from.path(), offset);
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
