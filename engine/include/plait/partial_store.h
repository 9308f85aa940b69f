// plait/partial_store.h: a store is made under a temporary name beside its final one, and takes the
// final name when it is whole, also in place of another store.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "plait/directory.h"
#include "plait/partial_output.h"

namespace plait {

/// The destructor removes what was not published.
class PartialStore {
 public:
  /// Errors: kNotFound if the directory to put it into is not there; kInvalidArgument if the name
  /// is taken, with kReplace by anything but a store; kBusy if somebody has that open.
  PartialStore(const std::filesystem::path& final_path, Existing existing);
  PartialStore(const PartialStore&) = delete;
  PartialStore& operator=(const PartialStore&) = delete;
  /// The constructor's refusals.
  static void check(const std::filesystem::path& final_path, Existing existing);

  /// Makes an empty directory NAME.partial-PID and locks it (flock). Returns where it is.
  /// Errors: kIo, kNoSpace.
  const std::filesystem::path& make();
  /// What make() returned; after kBusy of publish() where the store is that was made.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return output_.path; }

  /// Gives the store its final name; `durable` also makes the name durable. Of a store that is
  /// replaced the files are removed; what else was in its directory goes into the new one's, and
  /// `warn`, if given, is told of each. REQUIRES: make().
  /// Errors: kInvalidArgument if the name was taken meanwhile, by anything but a store; kBusy if
  /// somebody has opened the store to be replaced, and then what was made stays under a name that
  /// the message tells; kBadState if path() is not what was made any more; kIo, kNoSpace.
  void publish(bool durable, const std::function<void(const std::string&)>& warn = {});

 private:
  void replace_store(const std::function<void(const std::string&)>& warn);
  [[noreturn]] void stay_beside(const std::string& why);

  OutputName output_;
  Existing existing_;
  PartialDirectory made_;
  std::filesystem::path path_;
};

}  // namespace plait
