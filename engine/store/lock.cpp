#include "store/lock.h"

#include <fmt/format.h>
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
  if (file_.lock(exclusive)) {
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

void StoreLock::write_holder() {
  const std::string text = std::to_string(::getpid());
  file_.resize(0);
  file_.write_at(0, std::as_bytes(std::span(text)));
}

}  // namespace plait
