// tools/tune/scratch_directory.h: a directory of our own on the disk that is measured, so that no
// file of others is touched. The destructor removes it with all that is in it.
#pragma once

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "plait/error.h"

namespace plait::tune {

class ScratchDirectory {
 public:
  /// Errors: kNotFound without `parent`; kIo.
  ScratchDirectory(const std::filesystem::path& parent, std::string_view name) {
    std::string path = (parent / fmt::format("{}-XXXXXX", name)).string();
    if (::mkdtemp(path.data()) == nullptr) {
      const int number = errno;
      throw Error(
          number == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo,
          fmt::format("measure the disk under {}: {}", parent.native(), std::strerror(number)));
    }
    path_ = path;
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace plait::tune
