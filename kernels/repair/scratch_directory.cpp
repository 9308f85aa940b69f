#include "repair/scratch_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "plait/error.h"

namespace plait {
namespace fs = std::filesystem;

ScratchDirectory::ScratchDirectory(const fs::path& store) {
  fs::path name = store.lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  // The name may be taken by what a killed process of the same number left.
  for (int attempt = 0; attempt == 0 || fs::exists(fs::symlink_status(path_)); ++attempt) {
    path_ = name;
    path_ += fmt::format(".repair-{}", ::getpid());
    if (attempt > 0) path_ += fmt::format("-{}", attempt);
  }
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  if (directory_.is_open()) fs::remove_all(path_, ignored);
}

const Directory& ScratchDirectory::directory() {
  if (!directory_.is_open()) directory_ = Directory::make(path_);
  return directory_;
}

const fs::path& ScratchDirectory::path() { return directory().path(); }

}  // namespace plait
