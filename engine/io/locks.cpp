#include "io/locks.h"

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/vfs.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <iterator>

#include "io/system_call.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr int kNotSupportedByKernel = 524;  // ENOTSUPP, which errno.h does not have

/// NFS answers EBADF for an exclusive lock of what is not open for writing, as a directory never
/// is, and file systems that know no locks EBADF or EINVAL; a filter of system calls EPERM.
bool means_no_locks(int error) {
  return error == EBADF || error == ENOLCK || error == ENOSYS || error == EOPNOTSUPP ||
         error == EINVAL || error == EPERM || error == kNotSupportedByKernel;
}

/// The file systems that several machines, or several mounts with locks of their own, can share.
/// The numbers are f_type of statfs(2), which no header has all of.
constexpr std::uint32_t kShared[] = {
    0x6969,      // NFS
    0x517b,      // SMB
    0xff534d42,  // CIFS
    0xfe534d42,  // SMB2
    0x65735546,  // FUSE
    0x0bd00bd0,  // Lustre
    0x19830326,  // BeeGFS
    0x47504653,  // GPFS
    0x00c36400,  // Ceph
    0x5346414f,  // AFS
    0x6b414653,  // kAFS
    0x01021997,  // 9P
    0x73757245,  // Coda
    0xaad7aaea,  // PanFS
    0x20030528,  // OrangeFS
    0x786f4256,  // VirtualBox
    0xbacbacbc,  // VMware
};

}  // namespace

bool take_lock(int descriptor, bool exclusive, const std::filesystem::path& path) {
  const int operation = (exclusive ? LOCK_EX : LOCK_SH) | LOCK_NB;
  if (attempt({FileOperation::Kind::kLock, path},
              [&](auto) { return ::flock(descriptor, operation); }) >= 0)
    return true;
  const int error = errno;
  if (error == EWOULDBLOCK) return false;
  if (means_no_locks(error))
    throw Error(ErrorCode::kNotSupported,
                fmt::format("lock {}: its file system has no locks (flock)", path.native()))
        .about(path);
  throw system_error("lock", path.native(), error);
}

bool locks_are_seen_by_all(int descriptor) noexcept {
  struct statfs status {};
  if (::fstatfs(descriptor, &status) != 0) return false;
  const auto type = static_cast<std::uint32_t>(status.f_type);
  return std::find(std::begin(kShared), std::end(kShared), type) == std::end(kShared);
}

PLAIT_END_NAMESPACE
