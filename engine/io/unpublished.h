// io/unpublished.h: an output file or directory that never exists half-made under its final name. A
// program makes it under an unfinished name in the same directory; it gets its final name when it
// is complete. No other code makes such names. store/unpublished_store.h does the same for stores,
// which may replace stores, and store/new_output.h is the whole protocol.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "io/machine.h"
#include "io/process.h"
#include "plait/detail/namespace.h"
#include "plait/error.h"
#include "plait/existing.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_NAMESPACE

/// Splits the path `given` into its directory, which it opens, and its name there; "a/b/" is the
/// name b in the directory a. Errors: kNotFound naming the path if the directory does not exist;
/// kInvalidArgument if it ends in no name.
struct OutputName {
  explicit OutputName(const std::filesystem::path& given);

  Directory directory;
  std::string name;
  std::filesystem::path path;  ///< `given` in its shortest form, without a '/' at its end
};

/// Makes the name of a complete output durable. An error says that the output is complete under its
/// name. Errors: kIo.
void sync_name(const Directory& parent, const std::filesystem::path& path);

/// Makes a directory under the path that `next()` gives, and locks it. Again with the next path if
/// another process removes the directory before it is locked: it may take it for a left-over.
/// Errors: kIo, kNoSpace; kNotFound if there is no directory for it.
Directory make_locked_directory(const std::function<std::filesystem::path()>& next, bool exclusive);

/// An unfinished name, read.
struct UnfinishedNameParts : Maker {
  std::string_view stem;  ///< see UnfinishedName::stem_of()
  std::string_view kind;
};
/// Nothing for other names.
std::optional<UnfinishedNameParts> read_unfinished_name(std::string_view name);

/// Whether a process may still work in a directory whose name tells its maker: one of another
/// machine, one that has its lock (flock), or, where a lock may be seen by one mount only or there
/// are none, any that is not known to have ended. Takes the lock if that is free.
bool may_be_in_use(const Directory& directory, const Maker& maker);

/// The unfinished name NAME.KIND-HOST-START-PROCESS.RANDOM of a directory for an output with the
/// final name NAME. The process that makes the directory locks it (flock), and the lock ends with
/// the process. So a directory that may not be in use any more was left by a killed process.
/// store/left_overs.h finds these, and asks them for a proof that plait made them.
class UnfinishedName {
 public:
  /// `kind` is "partial", "repair", "replaced" or "complete". Errors: as OutputName.
  UnfinishedName(const std::filesystem::path& final_path, std::string kind);

  const Directory& parent() const { return output_.directory; }
  const std::string& final_name() const { return output_.name; }
  const std::filesystem::path& final_path() const { return output_.path; }
  /// Empty before next(), and after the file or directory got another name.
  const std::string& name() const { return name_; }
  std::filesystem::path path() const { return parent().path_of(name_).lexically_normal(); }

  /// What unfinished names of an output begin with, before the kind: its final name, or, if the
  /// file system has no room for so long a name, the begin of it and a hash.
  std::string stem_of(const std::string& final_name) const;
  /// Changes name() to a new one, and returns it. Errors: kIo.
  const std::string& next();
  /// Returns whether name() is the name of the file or directory that `descriptor` has open.
  /// Errors: kIo.
  bool is_of(int descriptor) const;
  /// Renames the file or directory to `to`. Returns false if `to` is taken (Renaming::kRefuse).
  /// Errors: kBadState if is_of(descriptor) is false; those of Directory::rename.
  bool give(int descriptor, const std::string& to, Renaming renaming);
  /// Exchanges the temporary name and the final name: the directory that `descriptor` has open gets
  /// the final name, the one that `other` has open gets the temporary name. Changes nothing and
  /// returns false if the final name does not belong to `other` any more. Errors: as give().
  bool exchange(int descriptor, int other);

 private:
  void require(int descriptor, const std::string& to);

  OutputName output_;
  std::string kind_, name_;
};

/// How a directory with an unfinished name proves that plait made it.
enum class MadeProof : std::uint8_t {
  kMark,      ///< io/made_mark.h
  kManifest,  ///< the manifest of a store, which is made there and gets the directory
};

/// A new directory with an unfinished name: for a store or a plan, which gets its final name, or
/// for an output and the temporary files of a repair. The destructor removes the directory if it
/// still has its unfinished name.
class UnpublishedDirectory {
 public:
  /// Removes the files that the user of the class makes in the directory, and no others. If other
  /// files are in the directory, it stays.
  using RemoveContent = void (*)(const Directory&);

  UnpublishedDirectory(std::filesystem::path final_path, std::string kind, MadeProof proof,
                       RemoveContent remove_content);
  ~UnpublishedDirectory();
  UnpublishedDirectory(const UnpublishedDirectory&) = delete;
  UnpublishedDirectory& operator=(const UnpublishedDirectory&) = delete;

  /// The first call makes the directory, locked and empty but for its mark.
  /// Errors: as OutputName; kIo, kNoSpace.
  const Directory& directory();
  const std::filesystem::path& final_path() const noexcept { return final_path_; }
  /// What directory() returned; closed before directory().
  const Directory& made() const noexcept { return made_; }
  /// Its unfinished name. REQUIRES: directory().
  UnfinishedName& name() { return *name_; }

  /// Renames the directory to its final name, and then removes its mark; `durable` syncs the
  /// directory before that, and the name afterwards. Returns false and renames nothing if the name
  /// is taken. REQUIRES: directory(). Errors: kBadState if the directory does not have its
  /// unfinished name any more; kIo, kNoSpace.
  bool publish(bool durable);
  /// Whether publish() has renamed it.
  bool has_final_name() const noexcept { return has_final_name_; }
  /// Keeps the directory, which is complete, under a name of the kind "complete", or, if that
  /// fails, under the name that it has. No run removes it. Returns its path. REQUIRES: directory().
  std::filesystem::path keep() noexcept;

 private:
  std::filesystem::path final_path_;
  std::string kind_;
  MadeProof proof_;
  RemoveContent remove_content_;
  std::optional<UnfinishedName> name_;
  Directory made_;
  bool has_final_name_ = false, is_kept_ = false;
  const OwnProcess process_;  ///< the only one that may remove the directory
};

/// A new file in a directory with an unfinished name, which it leaves for its final name. The
/// destructor removes a file that was not published.
class UnpublishedFile {
 public:
  /// Makes nothing yet. Errors: kNotFound if the directory does not exist; kInvalidArgument if the
  /// name is taken and `existing` is kRefuse, or if the name belongs to anything but a regular
  /// file; kIo.
  UnpublishedFile(const std::filesystem::path& path, Existing existing);
  ~UnpublishedFile();
  /// Throws the same kNotFound and kInvalidArgument as the constructor, and creates nothing.
  static void check(const std::filesystem::path& path, Existing existing);
  UnpublishedFile(const UnpublishedFile&) = delete;
  UnpublishedFile& operator=(const UnpublishedFile&) = delete;

  /// The first call makes the file. Errors: kIo, kNoSpace.
  File& file();
  /// The unfinished path; empty before file().
  const std::filesystem::path& path() const noexcept { return file_.path(); }
  const std::filesystem::path& final_path() const noexcept { return made_.final_path(); }

  /// Syncs the content, renames the file to its final name, and syncs the directory.
  /// If the file cannot get its name, it stays, complete, under a name that the error tells.
  /// REQUIRES: file(). Errors: kInvalidArgument if another process took the name meanwhile;
  /// kBadState if the file does not have its unfinished name any more; kIo, kNoSpace.
  void publish();
  /// Keeps the file, which is complete, under a name of the kind "complete", or, if no renaming
  /// succeeds, under its unfinished one. No run removes it. Returns its path. REQUIRES: file().
  std::filesystem::path keep() noexcept;

 private:
  bool has_its_name() const;

  const OwnProcess process_;  ///< the only one that may remove the file
  Existing existing_;
  UnpublishedDirectory made_;
  File file_;
  bool is_kept_ = false;
};

/// Returns `text` with each `unfinished` in it replaced by `final_path`.
std::string with_final_name(std::string text, const std::filesystem::path& unfinished,
                            const std::filesystem::path& final_path);
/// Returns `error` with the path `unfinished` replaced by `final_path`: the user never gave the
/// unfinished one.
Error with_final_name(const Error& error, const std::filesystem::path& unfinished,
                      const std::filesystem::path& final_path);

/// Calls `work` and returns its result. Errors of `work` get the final name by with_final_name().
/// Output is UnpublishedFile or UnpublishedStore.
template <class Output, class Work>
auto build_output(const Output& output, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw with_final_name(error, output.path(), output.final_path());
  }
}

PLAIT_END_NAMESPACE
