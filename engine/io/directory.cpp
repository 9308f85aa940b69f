#include "plait/extend/directory.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

#include "io/descriptor.h"
#include "io/locks.h"
#include "io/system_call.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Kind = FileOperation::Kind;

/// File systems without RENAME_NOREPLACE or RENAME_EXCHANGE fail with one of these, and so do
/// filters of system calls. Where a name may not be changed (EPERM), the plain call fails too.
bool is_unsupported(int errno_value) {
  return errno_value == EINVAL || errno_value == ENOSYS || errno_value == ENOTSUP ||
         errno_value == EPERM;
}

unsigned renaming_flags(Renaming renaming) {
  switch (renaming) {
    case Renaming::kReplace:
      return 0;
    case Renaming::kRefuse:
      return RENAME_NOREPLACE;
    case Renaming::kExchange:
      return RENAME_EXCHANGE;
  }
  return 0;
}

}  // namespace

Directory::Directory(const std::filesystem::path& path) : path_(path) {
  descriptor_ = static_cast<int>(attempt({Kind::kOpen, path_}, [&](auto) {
    return above_standard_streams(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  }));
  if (descriptor_ >= 0) return;
  if (errno == ENOTDIR)
    throw Error(ErrorCode::kNotFound,
                fmt::format("open {}: expected a directory, found something else", path.native()));
  throw system_error("open", path.native(), errno);
}

Directory::Directory(const Directory& parent, const std::string& name)
    : path_(parent.path_of(name)) {
  descriptor_ = static_cast<int>(attempt({Kind::kOpen, path_}, [&](auto) {
    return above_standard_streams(::openat(parent.descriptor_, name.c_str(),
                                           O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  }));
  if (descriptor_ >= 0) return;
  if (errno == ENOTDIR || errno == ELOOP)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("open {}: expected a directory, found something else", path_.native()));
  throw system_error("open", path_.native(), errno);
}

Directory Directory::make(const std::filesystem::path& path) {
  if (attempt({Kind::kMakeDirectory, path}, [&](auto) { return ::mkdir(path.c_str(), 0777); }) < 0)
    throw system_error("create", path.native(), errno);
  try {
    return Directory(path);
  } catch (...) {
    ::rmdir(path.c_str());
    throw;
  }
}

namespace {

/// The path in normal form, without a '/' at its end.
std::filesystem::path normal(const std::filesystem::path& path) {
  const std::filesystem::path whole = path.lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

}  // namespace

std::string Directory::name() const { return normal(path_).filename(); }

Directory Directory::parent() const {
  const std::filesystem::path above = normal(path_).parent_path();
  Directory result;
  result.path_ = above.empty() ? std::filesystem::path(".") : above;
  result.descriptor_ =
      above_standard_streams(::openat(descriptor_, "..", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (result.descriptor_ < 0) throw system_error("open", result.path_.native(), errno);
  return result;
}

Directory::~Directory() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Directory::Directory(Directory&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

Directory& Directory::operator=(Directory&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

bool Directory::contains(const std::string& name) const {
  struct stat status {};
  if (::fstatat(descriptor_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) return true;
  if (errno == ENOENT) return false;
  throw system_error("stat", path_of(name).native(), errno);
}

bool Directory::contains(const std::string& name, int descriptor) const {
  struct stat named {
  }, held{};
  if (::fstat(descriptor, &held) != 0) throw system_error("stat", path_of(name).native(), errno);
  if (::fstatat(descriptor_, name.c_str(), &named, AT_SYMLINK_NOFOLLOW) == 0)
    return named.st_dev == held.st_dev && named.st_ino == held.st_ino;
  if (errno == ENOENT) return false;
  throw system_error("stat", path_of(name).native(), errno);
}

std::vector<std::string> Directory::names() const {
  // A new descriptor: the read position belongs to the open directory, so reading through
  // `descriptor_` would move it for all threads.
  const int descriptor =
      above_standard_streams(::openat(descriptor_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor < 0) throw system_error("open", path_.native(), errno);
  struct Close {
    void operator()(DIR* stream) const { ::closedir(stream); }
  };
  const std::unique_ptr<DIR, Close> stream(::fdopendir(descriptor));
  if (!stream) {
    const int error = errno;
    ::close(descriptor);
    throw system_error("read", path_.native(), error);
  }
  std::vector<std::string> names;
  while (true) {
    errno = 0;
    const dirent* const entry = ::readdir(stream.get());
    if (entry == nullptr) break;
    std::string name = entry->d_name;
    if (name != "." && name != "..") names.push_back(std::move(name));
  }
  if (errno != 0) throw system_error("read", path_.native(), errno);
  std::ranges::sort(names);
  return names;
}

void Directory::remove(const std::string& name) const {
  const std::filesystem::path path = path_of(name);
  if (attempt({Kind::kRemove, path},
              [&](auto) { return ::unlinkat(descriptor_, name.c_str(), 0); }) < 0 &&
      errno != ENOENT)
    throw system_error("remove", path.native(), errno);
}

void Directory::remove_if_possible(const std::string& name) const noexcept {
  try {
    remove(name);
  } catch (const std::exception&) {  // the file stays
  }
}

bool Directory::remove_directory(const std::string& name) const {
  const std::filesystem::path path = path_of(name);
  if (attempt({Kind::kRemove, path},
              [&](auto) { return ::unlinkat(descriptor_, name.c_str(), AT_REMOVEDIR); }) >= 0)
    return true;
  if (errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR || errno == ENOENT) return false;
  throw system_error("remove", path.native(), errno);
}

bool Directory::remove_itself() const {
  const Directory above = parent();
  return above.contains(name(), descriptor_) && above.remove_directory(name());
}

bool Directory::rename(const std::string& from, const Directory& other, const std::string& to,
                       Renaming renaming) const {
  const std::filesystem::path from_path = path_of(from), to_path = other.path_of(to);
  const auto rename_with = [&](unsigned flags) {
    const Kind kind = flags == RENAME_EXCHANGE ? Kind::kExchange : Kind::kRename;
    return attempt({kind, from_path, 0, 0, &to_path}, [&](auto) {
             return ::renameat2(descriptor_, from.c_str(), other.descriptor_, to.c_str(), flags);
           }) >= 0;
  };
  if (rename_with(renaming_flags(renaming))) return true;
  if (renaming == Renaming::kRefuse) {
    if (errno == EEXIST) return false;
    if (is_unsupported(errno)) {
      if (other.contains(to)) return false;
      if (rename_with(0)) return true;
    }
  }
  if (renaming == Renaming::kExchange && is_unsupported(errno))
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("replace {}: its file system cannot exchange two names", to_path.native()));
  // A directory of a lower layer of an overlay, and a mount point, keep their names.
  if (errno == EXDEV || errno == EBUSY)
    throw Error(ErrorCode::kNotSupported, system_error("rename", from_path.native(), errno).what())
        .about(from_path);
  throw system_error("rename to", to_path.native(), errno);
}

void Directory::sync() const {
  if (attempt({Kind::kSyncDirectory, path_}, [&](auto) { return ::fsync(descriptor_); }) >= 0)
    return;
  // vboxsf, hgfs and some FUSE file systems cannot sync a directory, and answer so.
  if (errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP) return;
  throw system_error("sync", path_.native(), errno);
}

bool Directory::lock(bool exclusive) const { return take_lock(descriptor_, exclusive, path_); }

PLAIT_END_NAMESPACE
