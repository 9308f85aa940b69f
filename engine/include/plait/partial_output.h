// plait/partial_output.h: nothing half-made is left. A file or a directory is made under a
// temporary name beside its final one, and takes the final name when it is whole. The one place
// that makes temporary names. For stores that replace stores: plait/partial_store.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "plait/directory.h"
#include "plait/error.h"
#include "plait/file.h"

namespace plait {

enum class Existing : std::uint8_t {
  kRefuse,   ///< what is there stays
  kReplace,  ///< what is there goes when the new one is whole, and not before
};

/// The directory that `path` is in, and what it is called there; "a/b/" is b in a.
/// Errors: kNotFound naming `path` if there is no such directory; kInvalidArgument without a name.
struct OutputName {
  explicit OutputName(const std::filesystem::path& path);

  Directory directory;
  std::string name;
  std::filesystem::path path;  ///< normal, without a '/' at its end
};

/// A name NAME.KIND-PID beside the final name NAME, and the entry that has it. Whoever makes the
/// entry holds a lock on it (flock), which ends with the process: an entry that is not locked was
/// left by a process that was killed, and plait/left_overs.h finds it by its name.
class TemporaryName {
 public:
  /// `kind` is "partial" or the like. Errors: as OutputName.
  TemporaryName(const std::filesystem::path& final_path, std::string kind);

  const Directory& parent() const { return output_.directory; }
  const std::string& final_name() const { return output_.name; }
  const std::filesystem::path& final_path() const { return output_.path; }
  /// Empty while no entry has it.
  const std::string& name() const { return name_; }
  std::filesystem::path path() const { return parent().path_of(name_).lexically_normal(); }

  /// Takes the next name that is free: names may be in use by another thread, or left by a killed
  /// process of the same number. Errors: kIo.
  const std::string& next();
  /// Whether the entry of this name is what `descriptor` is open on. Errors: kIo.
  bool is_of(int descriptor) const;
  /// Gives the entry the name `to`, after which the temporary name is nobody's. False if `to` is
  /// taken (Renaming::kRefuse). Errors: kBadState if the entry is not what `descriptor` is open on
  /// any more; those of Directory::rename.
  bool give(int descriptor, const std::string& to, Renaming renaming);
  /// Exchanges the names of the entry, which `descriptor` is open on, and of what has the final
  /// name, which `other` is open on and which has the temporary name from then on. False, and
  /// nothing is changed, if another one has the final name by now. Errors: as give().
  bool exchange(int descriptor, int other);

 private:
  void require(int descriptor, const std::string& to);

  OutputName output_;
  std::string kind_, name_;
  int attempt_ = 0;
};

/// A new file. The destructor removes what was not published.
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
  const std::filesystem::path& final_path() const noexcept { return name_.final_path(); }

  /// Makes the content durable, then the name. Errors: kInvalidArgument if the name was taken
  /// meanwhile; kBadState if path() is not what was made any more; kIo, kNoSpace.
  void publish();

 private:
  Existing existing_;
  TemporaryName name_;
  File file_;
};

/// A new directory, for what is published (a store) or gone afterwards (what a repair makes on the
/// way). The destructor removes it while it still has its temporary name.
class PartialDirectory {
 public:
  /// Removes from the directory what its user makes in it, and nothing else: a directory in which
  /// something stays is not removed.
  using RemoveContent = void (*)(const Directory&);

  PartialDirectory(std::filesystem::path final_path, std::string kind,
                   RemoveContent remove_content);
  ~PartialDirectory();
  PartialDirectory(const PartialDirectory&) = delete;
  PartialDirectory& operator=(const PartialDirectory&) = delete;

  /// Makes the directory, empty and locked, when it is first asked for.
  /// Errors: as OutputName; kIo, kNoSpace.
  const Directory& directory();
  /// Its temporary name. REQUIRES: directory().
  TemporaryName& name() { return *name_; }

  /// Gives the directory its final name; `durable` syncs the directory before and its name after.
  /// False if the name is taken, and then nothing is changed. REQUIRES: directory().
  /// Errors: kBadState if the directory has its temporary name no more; kIo, kNoSpace.
  bool publish(bool durable);
  /// Keeps the directory under a name NAME.KIND-PID that is not its final one, and makes that name
  /// durable. Returns where it is. REQUIRES: directory(). Errors: as publish().
  std::filesystem::path keep_as(std::string kind);

 private:
  std::filesystem::path final_path_;
  std::string kind_;
  RemoveContent remove_content_;
  std::optional<TemporaryName> name_;
  Directory made_;
};

/// `error` with the path `temporary` replaced by `final_path`, which is the one that the user gave.
Error with_final_name(const Error& error, const std::filesystem::path& temporary,
                      const std::filesystem::path& final_path);

/// Returns what `work` returns; its errors have passed with_final_name().
/// Output: PartialFile, PartialStore.
template <class Output, class Work>
auto build_output(const Output& output, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    throw with_final_name(error, output.path(), output.final_path());
  }
}

}  // namespace plait
