// store/unpublished_store.h: an output store that never exists half-made under its final name. A
// program makes the store under an unfinished name in the same directory, and renames it when it is
// complete. io/unpublished.h does the same for files. Most programs take store/new_output.h.
#pragma once

#include <filesystem>
#include <string>

#include "io/unpublished.h"
#include "plait/detail/namespace.h"
#include "plait/extend/directory.h"
#include "store/left_overs.h"

PLAIT_BEGIN_NAMESPACE

/// The destructor removes a store that was not complete. A complete one stays, whatever happens.
class UnpublishedStore {
 public:
  /// Removes what killed runs of this machine have left of this output. Errors: kNotFound if the
  /// directory of `final_path` does not exist; kInvalidArgument if the name is taken (with
  /// kReplace, if it is taken by anything but a store); kBusy if another process has the existing
  /// store open.
  UnpublishedStore(const std::filesystem::path& final_path, Existing existing, Warn warn);
  UnpublishedStore(const UnpublishedStore&) = delete;
  UnpublishedStore& operator=(const UnpublishedStore&) = delete;
  /// Throws the same errors as the constructor, and changes nothing.
  static void check(const std::filesystem::path& final_path, Existing existing);

  /// Makes an empty directory with an unfinished name, locks it (flock) and returns its path. With
  /// kReplace, tries what publish() will need, and tells `warn` if the file system cannot exchange
  /// names. Errors: kNotSupported if the existing store cannot be renamed; kIo, kNoSpace.
  const std::filesystem::path& make();
  /// The path that make() returned; after publish() threw, the path where the new store is.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return output_.path; }

  /// Gives the store its final name; `durable` also syncs the directory. With kReplace, removes the
  /// files of the replaced store, moves other files of its directory to the new one, and warns of
  /// each of those. Where names cannot be exchanged, it takes two renames, and a program that opens
  /// the store between them finds none. If the store cannot get its name, it stays, complete, under
  /// a name that the error tells. REQUIRES: make(). Errors: kInvalidArgument if the name was taken
  /// meanwhile by anything but a store; kBusy if another process has opened the store to be
  /// replaced; kBadState if the directory at path() is not the one from make() any more; kIo,
  /// kNoSpace.
  void publish(bool durable);

 private:
  void give_name(bool durable);
  void replace_store();
  /// The old store then has the unfinished name that is returned. Errors: kBusy if another process
  /// has replaced the old one.
  std::string exchange_names(const Directory& replaced);
  std::string rename_twice(const Directory& replaced);
  void try_replacing();
  bool can_exchange_names(UnfinishedName& other);
  void tell(const std::string& what) const {
    if (warn_) warn_(what);
  }

  OutputName output_;
  Existing existing_;
  Warn warn_;
  UnpublishedDirectory made_;
  std::filesystem::path path_;
  bool can_exchange_ = true, has_final_name_ = false;
};

PLAIT_END_NAMESPACE
