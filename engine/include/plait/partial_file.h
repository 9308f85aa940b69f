// plait/partial_file.h: an output file that never exists half-written under its final name. The
// program writes it under a temporary name in the same directory; the file gets its final name when
// it is complete.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "plait/directory.h"
#include "plait/file.h"

namespace plait {

enum class Existing : std::uint8_t {
  kRefuse,   ///< an existing file stays, and is an error
  kReplace,  ///< the new file replaces an existing one, when the new file is complete
};

/// The temporary name of an output with the final name `name`: NAME.KIND-PID, and
/// NAME.KIND-PID-ATTEMPT for `attempt` > 0.
std::string temporary_name(const std::string& name, const std::string& kind, int attempt);

/// A new file NAME.partial-PID. It is locked (flock) while its process writes it, so an unlocked
/// one was left by a process that was killed. The destructor removes a file that was not published.
class PartialFile {
 public:
  /// Errors: kNotFound if the directory does not exist; kInvalidArgument if the name is taken and
  /// `existing` is kRefuse, or if the name belongs to anything but a regular file; kIo, kNoSpace.
  PartialFile(const std::filesystem::path& path, Existing existing);
  ~PartialFile();
  /// Throws the same kNotFound and kInvalidArgument as the constructor, and creates nothing.
  static void check(const std::filesystem::path& path, Existing existing);
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  File& file() noexcept { return file_; }
  /// The temporary path.
  const std::filesystem::path& path() const noexcept { return file_.path(); }
  const std::filesystem::path& final_path() const noexcept { return path_; }

  /// Syncs the content, renames the file to its final name, and syncs the directory.
  /// Errors: kInvalidArgument if another process took the name meanwhile; kIo, kNoSpace.
  void publish();

 private:
  std::filesystem::path path_;
  Existing existing_;
  Directory directory_;
  std::string name_, partial_name_;
  File file_;
};

/// Splits `path` into its directory, which it opens, and its name there; "a/b/" is the name b in
/// the directory a.
/// Errors: kNotFound naming `path` if the directory does not exist; kInvalidArgument if `path` ends
/// in no name.
struct OutputName {
  explicit OutputName(const std::filesystem::path& path);

  Directory directory;
  std::string name;
};

}  // namespace plait
