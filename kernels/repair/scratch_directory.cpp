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
  if (made_) fs::remove_all(path_, ignored);
}

const fs::path& ScratchDirectory::path() {
  if (made_) return path_;
  std::error_code error;
  fs::create_directory(path_, error);
  if (error) throw system_error("create", path_.native(), error.value());
  made_ = true;
  return path_;
}

}  // namespace plait
