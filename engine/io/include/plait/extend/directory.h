// plait/extend/directory.h: an open directory. A path may name another directory a moment later;
// the descriptor of an open directory always means the same one. So files inside a store are
// opened, renamed and removed through the descriptor. Every operation calls the hook of
// io/file_operations.h, as the operations of plait/extend/file.h do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// What rename() does if the new name is taken.
enum class Renaming : std::uint8_t {
  kReplace,   ///< the entry that had the name is removed, in one step
  kRefuse,    ///< nothing is renamed
  kExchange,  ///< the two entries exchange their names; both must exist
};

/// The descriptor of a directory. A `name` is the name of an entry in this directory: one path
/// component, without '/'. Const calls are safe from several threads.
class Directory {
 public:
  Directory() = default;
  /// Opens the directory that `path` names now, following symbolic links.
  /// Errors: kNotFound if nothing has that name, or if it is not a directory; kIo.
  explicit Directory(const std::filesystem::path& path);
  /// Opens the entry `name` of `parent`. The entry must be a directory, and not a symbolic link to
  /// one.
  /// Errors: kNotFound if there is no such entry; kInvalidArgument if the entry is not a directory;
  /// kIo.
  Directory(const Directory& parent, const std::string& name);
  /// Makes the directory and opens it. Errors: kIo, also if the name is taken; kNoSpace.
  static Directory make(const std::filesystem::path& path);
  /// The directory that contains this one now. Errors: kIo.
  Directory parent() const;
  /// The last component of the path by which the directory was opened.
  std::string name() const;
  ~Directory();
  Directory(Directory&& other) noexcept;
  Directory& operator=(Directory&& other) noexcept;

  bool is_open() const noexcept { return descriptor_ >= 0; }
  int descriptor() const noexcept { return descriptor_; }
  /// The path by which the directory was opened, for messages. The directory may have another name
  /// by now.
  const std::filesystem::path& path() const noexcept { return path_; }
  std::filesystem::path path_of(const std::string& name) const { return path_ / name; }

  /// Whether an entry of any kind has that name. A symbolic link counts as an entry, whatever it
  /// points to.
  /// Errors: kIo.
  bool contains(const std::string& name) const;
  /// Whether the entry `name` of this directory is the file that `descriptor` has open. Errors:
  /// kIo.
  bool contains(const std::string& name, int descriptor) const;
  /// The names of all entries except "." and "..", sorted. Errors: kIo.
  std::vector<std::string> names() const;

  /// Removes a file, a link or any other entry that is not a directory. A missing entry is not an
  /// error.
  /// Errors: kIo.
  void remove(const std::string& name) const;
  /// Removes a left-over file. A failure is ignored: the file then stays.
  void remove_if_possible(const std::string& name) const noexcept;
  /// Removes an empty directory. Returns false if `name` is not empty or is not a directory.
  /// Errors: kIo.
  bool remove_directory(const std::string& name) const;

  /// Removes this directory if it is empty and still has the name by which it was opened. Returns
  /// false if it does not remove the directory. Errors: kIo.
  bool remove_itself() const;

  /// Gives the entry `from` the name `to` in the directory `other`, on the same file system. With
  /// kRefuse, returns false if `to` is taken; a file system that cannot check and rename in one
  /// step does it in two. Errors: kNotSupported for kExchange on a file system that cannot exchange
  /// names, and for a directory that cannot be renamed: one of a lower layer of an overlay, or a
  /// mount point; kIo, kNoSpace.
  bool rename(const std::string& from, const Directory& other, const std::string& to,
              Renaming renaming = Renaming::kReplace) const;

  /// Makes the names in the directory durable. Errors: kIo.
  void sync() const;
  /// Takes a lock with flock, as File::lock does. Errors: as there.
  bool lock(bool exclusive) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

PLAIT_END_NAMESPACE
