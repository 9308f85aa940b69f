#include "store/lock.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <string>

#include "plait/error.h"

namespace plait {
namespace {

std::string holder_text(const File& file) {
  char text[32] = {};
  const ssize_t got = ::pread(file.descriptor(), text, sizeof(text) - 1, 0);
  return got > 0 ? fmt::format("process {}", std::string(text, strnlen(text, sizeof(text))))
                 : std::string("another process");
}

}  // namespace

StoreLock::StoreLock(const std::filesystem::path& path, bool exclusive, bool create)
    : file_(path, create      ? OpenMode::kCreate
                  : exclusive ? OpenMode::kReadWrite
                              : OpenMode::kRead) {
  try {
    take(path, exclusive);
  } catch (...) {
    if (create) remove_file_if_possible(path);
    throw;
  }
}

void StoreLock::take(const std::filesystem::path& path, bool exclusive) {
  if (file_.lock(exclusive)) {
    check_name(path);
    if (exclusive) write_holder();
    return;
  }
  // Readers leave no name, and do not keep another one out.
  if (exclusive && file_.lock(false))
    throw Error(ErrorCode::kBusy,
                fmt::format("open {} for writing: in use by readers", path.native()));
  throw Error(ErrorCode::kBusy, fmt::format("open {}: in use by {}, which writes it", path.native(),
                                            holder_text(file_)));
}

/// Between opening and locking another store may have taken the name.
void StoreLock::check_name(const std::filesystem::path& path) const {
  struct stat held {
  }, named{};
  if (::fstat(file_.descriptor(), &held) == 0 && ::stat(path.c_str(), &named) == 0 &&
      held.st_dev == named.st_dev && held.st_ino == named.st_ino)
    return;
  throw Error(ErrorCode::kBusy,
              fmt::format("open {}: the store is being replaced or removed", path.native()));
}

void StoreLock::write_holder() {
  const std::string text = std::to_string(::getpid());
  file_.resize(0);
  file_.write_at(0, std::as_bytes(std::span(text)));
}

}  // namespace plait
