#include "instrument/scratch_directory.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <cerrno>
#include <string_view>
#include <system_error>

#include "io/made_mark.h"
#include "plait/error.h"

namespace plait::instrument {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kScratchPrefix = "plait-scratch-";

Directory make_locked(const fs::path& parent) {
  std::string path = (parent / (std::string(kScratchPrefix) + "XXXXXX")).native();
  if (::mkdtemp(path.data()) == nullptr) {
    if (errno == ENOENT)
      throw Error(ErrorCode::kNotFound,
                  "measure under " + parent.native() + ": expected a directory, found none");
    throw system_error("create", path, errno);
  }
  Directory made{fs::path(path)};
  if (!made.lock(true))
    throw Error(ErrorCode::kBusy, "measure under " + path + ": another process has locked it");
  // After the lock, so a directory that has the mark and no lock is of a dead run.
  write_made_mark(made);
  return made;
}

std::uint64_t bytes_under(const fs::path& path) {
  std::uint64_t bytes = 0;
  std::error_code failed;
  for (fs::recursive_directory_iterator at(path, failed), end; at != end && !failed;
       at.increment(failed))
    if (std::error_code none; at->is_regular_file(none) && !at->is_symlink(none)) {
      const std::uint64_t size = at->file_size(none);
      if (!none) bytes += size;
    }
  return bytes;
}

/// The mark goes last: what is left if this process is killed here is still found.
bool remove_all_of(const Directory& directory) {
  std::error_code failed;
  for (const std::string& name : directory.names())
    if (name != kMadeMarkName && !failed) fs::remove_all(directory.path_of(name), failed);
  if (!failed) fs::remove_all(directory.path(), failed);
  return !failed;
}

}  // namespace

ScratchDirectory::ScratchDirectory(const fs::path& parent) {
  if (std::error_code none; fs::is_directory(parent, none)) find_scratch(parent, true);
  directory_ = make_locked(parent);
}

ScratchDirectory::~ScratchDirectory() {
  if (directory_.is_open()) try {
      remove_all_of(directory_);
    } catch (const Error&) {  // the next run removes it
    }
}

std::vector<FoundScratch> find_scratch(const fs::path& parent, bool remove) {
  std::vector<FoundScratch> found;
  const Directory directory(parent);
  for (const std::string& name : directory.names()) {
    struct stat status {};
    if (!name.starts_with(kScratchPrefix) ||
        ::fstatat(directory.descriptor(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0 ||
        !S_ISDIR(status.st_mode))
      continue;
    try {
      const Directory inner(directory, name);
      if (!has_made_mark(inner)) continue;
      FoundScratch one{name, bytes_under(inner.path()), !inner.lock(true), false};
      one.removed = remove && !one.in_use && remove_all_of(inner);
      found.push_back(std::move(one));
    } catch (const Error&) {  // not ours to open, or another process has removed it
      continue;
    }
  }
  return found;
}

}  // namespace plait::instrument
