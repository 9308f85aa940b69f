// plait/partial_file.h: nothing half-made is left. A file is written under a temporary name beside
// its final one, and takes that name when it is whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

enum class Existing : std::uint8_t {
  kRefuse,   ///< what is there stays
  kReplace,  ///< what is there goes when the new one is whole, and not before
};

/// The name for what process `process` makes on the way to `name`; `kind` is "partial" or the like.
std::string temporary_name(const std::string& name, const std::string& kind, int attempt);

/// A new file NAME.partial-PID, locked (flock) as long as it is under way: what is not locked was
/// left by a process that was killed. The destructor removes what was not published.
class PartialFile {
 public:
  /// Errors: kNotFound if the directory is not there; kInvalidArgument if the name is taken by what
  /// `existing` does not let go, and by anything but a regular file; kIo, kNoSpace.
  PartialFile(const std::filesystem::path& path, Existing existing);
  ~PartialFile();
  /// The constructor's refusals, before anything is made.
  static void check(const std::filesystem::path& path, Existing existing);
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  File& file() noexcept { return file_; }
  /// Where it is written.
  const std::filesystem::path& path() const noexcept { return file_.path(); }
  const std::filesystem::path& final_path() const noexcept { return path_; }

  /// Makes the content durable, then the name. Errors: kInvalidArgument if the name was taken
  /// meanwhile; kIo, kNoSpace.
  void publish();

 private:
  std::filesystem::path path_;
  Existing existing_;
  Directory directory_;
  std::string name_, partial_name_;
  File file_;
};

/// The directory that `path` is in, and what it is called there; "a/b/" is b in a.
/// Errors: kNotFound naming `path` if there is no such directory; kInvalidArgument without a name.
struct OutputName {
  explicit OutputName(const std::filesystem::path& path);

  Directory directory;
  std::string name;
};

}  // namespace plait
