// store/partial_store.h: an output store that never exists half-made under its final name. A
// program makes the store under a temporary name in the same directory, and renames it when it is
// complete. io/partial_output.h does the same for files.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "io/partial_output.h"
#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_NAMESPACE

/// The destructor removes a store that was not published.
class PartialStore {
 public:
  /// Errors: kNotFound if the directory of `final_path` does not exist; kInvalidArgument if the
  /// name is taken (with kReplace, if it is taken by anything but a store); kBusy if another
  /// process has the existing store open.
  PartialStore(const std::filesystem::path& final_path, Existing existing);
  PartialStore(const PartialStore&) = delete;
  PartialStore& operator=(const PartialStore&) = delete;
  /// Throws the same errors as the constructor, and creates nothing.
  static void check(const std::filesystem::path& final_path, Existing existing);

  /// Makes an empty directory NAME.partial-PID, locks it (flock) and returns its path.
  /// Errors: kIo, kNoSpace.
  const std::filesystem::path& make();
  /// The path that make() returned; after publish() threw kBusy, the path where the new store is.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return output_.path; }

  /// Gives the store its final name; `durable` also syncs the directory. With kReplace, removes the
  /// files of the replaced store, moves other files of its directory to the new one, and calls
  /// `warn` for each of those. REQUIRES: make().
  /// Errors: kInvalidArgument if the name was taken meanwhile by anything but a store; kBusy if
  /// another process has opened the store to be replaced (then the new store stays, under a name
  /// that the message gives); kBadState if the directory at path() is not the one from make() any
  /// more; kIo, kNoSpace.
  void publish(bool durable, const std::function<void(const std::string&)>& warn = {});

 private:
  void replace_store(const std::function<void(const std::string&)>& warn);
  [[noreturn]] void stay_beside(const std::string& why);

  OutputName output_;
  Existing existing_;
  PartialDirectory made_;
  std::filesystem::path path_;
};

PLAIT_END_NAMESPACE
