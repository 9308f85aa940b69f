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
  std::error_code ignored;
  for (int attempt = 0; attempt == 0 || fs::exists(fs::symlink_status(path_, ignored)); ++attempt) {
    path_ = name;
    path_ += fmt::format(".repair-{}", ::getpid());
    if (attempt > 0) path_ += fmt::format("-{}", attempt);
  }
}

ScratchDirectory::~ScratchDirectory() {
  if (!directory_.is_open()) return;
  try {
    // Whatever has the name by now stays, unless it is the directory that was made.
    if (!directory_.parent().contains(directory_.name(), directory_.descriptor())) return;
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  } catch (const Error&) {  // the next repair removes it
  }
}

const Directory& ScratchDirectory::directory() {
  if (directory_.is_open()) return directory_;
  directory_ = Directory::make(path_);
  directory_.lock(false);  // what is not locked is left over, and the next run removes it
  return directory_;
}

const fs::path& ScratchDirectory::path() { return directory().path(); }

}  // namespace plait
