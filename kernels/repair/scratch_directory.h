// A directory beside the store for what repair makes on the way; gone with the object.
#pragma once

#include <filesystem>

#include "plait/directory.h"

namespace plait {

class ScratchDirectory {
 public:
  explicit ScratchDirectory(const std::filesystem::path& store);
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  /// Makes the directory when it is first asked for. Errors: kIo, kNoSpace.
  const std::filesystem::path& path();
  const Directory& directory();

 private:
  std::filesystem::path path_;
  Directory directory_;
};

}  // namespace plait
