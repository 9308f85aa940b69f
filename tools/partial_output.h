// tools/partial_output.h: an output store that never exists half-made under its final name. A
// command makes the store under a temporary name in the same directory, and renames it when it is
// complete. plait/partial_file.h does the same for files.
#pragma once

#include <filesystem>
#include <string>

#include "plait/directory.h"
#include "plait/partial_file.h"

namespace plait {

/// The destructor removes a store that was not published.
class PartialOutput {
 public:
  /// Also removes left-overs of killed runs with the same output.
  /// Errors: kNotFound if the directory of `final_path` does not exist; kInvalidArgument if the
  /// name is taken (with kReplace, if it is taken by anything but a store); kBusy if another
  /// process has the existing store open.
  PartialOutput(const std::filesystem::path& final_path, Existing existing);
  ~PartialOutput();
  PartialOutput(const PartialOutput&) = delete;
  PartialOutput& operator=(const PartialOutput&) = delete;

  /// Makes an empty directory NAME.partial-PID, locks it (flock) and returns its path. Errors: kIo,
  /// kNoSpace.
  const std::filesystem::path& make();
  /// The path that make() returned.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return final_path_; }

  /// Gives the store its final name; `durable` also syncs the directory. With kReplace, removes the
  /// files of the replaced store, and moves other files of its directory to the new one.
  /// REQUIRES: make().
  /// Errors: kInvalidArgument if the name was taken meanwhile by anything but a store; kBusy if
  /// another process has opened the store to be replaced (then the new store stays, under a name
  /// that the message gives); kBadState if the directory at path() is not the one from make() any
  /// more; kIo, kNoSpace.
  void publish(bool durable);

 private:
  void replace_store();
  void keep_foreign(const Directory& replaced) const;
  [[noreturn]] void stay_beside(const std::string& why);

  std::filesystem::path final_path_, path_;
  Existing existing_;
  Directory parent_;
  std::string name_, partial_name_;
  Directory made_;
};

}  // namespace plait
