// tools/partial_output.h: no half-made store is left. A store is made under a temporary name beside
// its final one and takes that name when it is whole. For files: plait/partial_file.h.
#pragma once

#include <filesystem>
#include <string>

#include "plait/directory.h"
#include "plait/partial_file.h"

namespace plait {

/// The destructor removes what was not published.
class PartialOutput {
 public:
  /// Also removes what killed runs left of this name. Errors: kNotFound if the directory to put it
  /// into is not there; kInvalidArgument if the name is taken, with kReplace by anything but a
  /// store; kBusy if somebody has that open.
  PartialOutput(const std::filesystem::path& final_path, Existing existing);
  ~PartialOutput();
  PartialOutput(const PartialOutput&) = delete;
  PartialOutput& operator=(const PartialOutput&) = delete;

  /// Makes an empty directory NAME.partial-PID and locks it (flock). Returns where it is.
  /// Errors: kIo, kNoSpace.
  const std::filesystem::path& make();
  /// What make() returned.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return final_path_; }

  /// Renames; `durable` also syncs the directory. Of a store that is replaced the files are
  /// removed, and what else was beside them goes into the new one's directory. REQUIRES: make().
  /// Errors: kInvalidArgument if the name was taken meanwhile, by anything but a store; kBusy if
  /// somebody has opened the store to be replaced, and then what was made stays under a name that
  /// the message tells; kBadState if path() is not what was made any more; kIo, kNoSpace.
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
