#include "partial_output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string>
#include <system_error>

#include "plait/directory.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/store.h"

namespace plait {
namespace fs = std::filesystem;
namespace {

bool taken(const fs::path& path) { return fs::exists(fs::symlink_status(path)); }

Error taken_error(const fs::path& path) {
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("create {}: it exists, and --force was not given", path.native()));
}

void rename_entry(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw system_error("rename to", to.native(), errno);
}

/// Filesystems without RENAME_NOREPLACE or RENAME_EXCHANGE say one of these.
bool is_unsupported(int errno_value) {
  return errno_value == EINVAL || errno_value == ENOSYS || errno_value == ENOTSUP;
}

void rename_into_place(const fs::path& from, const fs::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return;
  if (errno == EEXIST) throw taken_error(to);
  if (!is_unsupported(errno)) throw system_error("rename to", to.native(), errno);
  if (taken(to)) throw taken_error(to);
  rename_entry(from, to);
}

/// Puts the directory `from` in place of the directory `to`, which then has the name `from`.
void exchange(const fs::path& from, const fs::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0) return;
  if (!is_unsupported(errno)) throw system_error("replace", to.native(), errno);
  const fs::path aside = from.native() + ".replaced";
  rename_entry(to, aside);
  try {
    rename_entry(from, to);
  } catch (...) {
    ::rename(aside.c_str(), to.c_str());
    throw;
  }
  rename_entry(aside, from);
}

}  // namespace

PartialOutput::PartialOutput(const fs::path& final_path, Existing existing) : existing_(existing) {
  if (final_path.empty())
    throw Error(ErrorCode::kInvalidArgument, "create output: its name is empty");
  final_path_ = final_path.lexically_normal();
  if (!final_path_.has_filename()) final_path_ = final_path_.parent_path();
  const fs::path parent = final_path_.parent_path();
  if (!parent.empty() && !fs::is_directory(parent))
    throw Error(ErrorCode::kNotFound, fmt::format("create {}: there is no directory {}",
                                                  final_path_.native(), parent.native()));
  if (existing_ == Existing::kRefuse && taken(final_path_)) throw taken_error(final_path_);
  // Never in place of a directory or, say, /dev/null.
  if (existing_ == Existing::kReplaceFile && taken(final_path_) &&
      !fs::is_regular_file(final_path_))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create {}: it exists and is no regular file", final_path_.native()));
  // The name may be taken by what a killed process of the same number left.
  for (int attempt = 0; attempt == 0 || taken(path_); ++attempt) {
    path_ = final_path_;
    path_ += fmt::format(".partial-{}", ::getpid());
    if (attempt > 0) path_ += fmt::format("-{}", attempt);
  }
}

PartialOutput::~PartialOutput() {
  if (published_) return;
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void PartialOutput::publish(bool durable) {
  if (existing_ == Existing::kReplaceFile) {
    rename_entry(path_, final_path_);
  } else if (existing_ == Existing::kReplaceStore && taken(final_path_)) {
    return replace_store(durable);
  } else {
    rename_into_place(path_, final_path_);
  }
  published_ = true;
  if (durable) sync_name();
}

/// The store that was there goes when the new one has its name for good, and not while anybody has
/// it open: whoever writes it would go on with the new one's files.
void PartialOutput::replace_store(bool durable) {
  std::optional<File> lock;
  const fs::path lock_path = final_path_ / "lock";  // docs/format.md; a damaged store may have none
  if (fs::is_regular_file(lock_path)) {
    lock.emplace(lock_path, OpenMode::kReadWrite);
    if (!lock->lock(true)) {
      published_ = true;  // so that what was made, in hours perhaps, stays
      throw Error(ErrorCode::kBusy, fmt::format("replace {}: it is in use; what should replace it "
                                                "is complete and stays at {}",
                                                final_path_.native(), path_.native()));
    }
  }
  exchange(path_, final_path_);
  published_ = true;
  if (durable) sync_name();
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void PartialOutput::sync_name() const {
  const fs::path parent = final_path_.parent_path();
  Directory(parent.empty() ? fs::path(".") : parent).sync();
}

void require_replaceable_store(const fs::path& path, const BackendRegistry& backends) {
  if (!taken(path)) return;
  try {
    // The writer's lock: refused while anybody reads or writes the store.
    OpenOptions options;
    options.writable = true;
    Store::open(path, options, backends).close();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCorruption || error.code() == ErrorCode::kNotSupported) return;
    if (error.code() == ErrorCode::kBusy) throw;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("replace {}: expected a store, found something else ({})",
                            path.native(), error.what()));
  }
}

}  // namespace plait
