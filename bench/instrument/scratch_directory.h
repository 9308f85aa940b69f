// bench/instrument/scratch_directory.h: a directory of our own for what a measurement makes, so
// that no file of others is touched. A lock says whether it is in use: it ends with the process, so
// what a killed run left is found and removed by the next run, and by `plait clean`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/extend/directory.h"

namespace plait::instrument {

/// Made in `parent`, locked, and removed with all that is in it by the destructor. The constructor
/// first removes what dead runs left in `parent`. A process that is forked shares the lock.
class ScratchDirectory {
 public:
  /// Errors: kNotFound without `parent`; kIo, kNoSpace.
  explicit ScratchDirectory(const std::filesystem::path& parent);
  ~ScratchDirectory();
  ScratchDirectory(ScratchDirectory&&) noexcept = default;
  ScratchDirectory& operator=(ScratchDirectory&&) = delete;
  const std::filesystem::path& path() const { return directory_.path(); }

 private:
  Directory directory_;
};

/// A directory with the name of one and, in it, the file that marks one.
struct FoundScratch {
  std::string name;
  std::uint64_t bytes = 0;  ///< of the files in it
  bool in_use = false;      ///< its process lives
  bool removed = false;
};

/// Those in `parent`, sorted by name. With `remove`, those of dead processes are removed. Errors:
/// kNotFound without `parent`; kIo. Pinned by tests/bench/instrument/scratch_directory_test.cpp.
std::vector<FoundScratch> find_scratch(const std::filesystem::path& parent, bool remove);

}  // namespace plait::instrument
