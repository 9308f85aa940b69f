// plait/directory.h: a directory that is held open, so that everything in it is reached by the
// directory itself and not by a path that may mean another one a moment later. Every operation
// passes plait/file_operations.h, as those of plait/file.h do.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace plait {

/// What to do about a name that is taken.
enum class Renaming : std::uint8_t {
  kReplace,   ///< what has the name goes, in one step
  kRefuse,    ///< nothing is renamed
  kExchange,  ///< the two change names; both must be there
};

/// The descriptor of a directory. Names are of entries of the directory itself: one component, no
/// '/'. Const calls are safe from several threads.
class Directory {
 public:
  Directory() = default;
  /// Opens the directory that `path` names now; a link in the path is followed.
  /// Errors: kNotFound if it is not there or is no directory; kIo.
  explicit Directory(const std::filesystem::path& path);
  /// Makes the directory and opens it. Errors: kIo, kNoSpace; also if the name is taken.
  static Directory make(const std::filesystem::path& path);
  /// The directory that holds this one now. Errors: kIo.
  Directory parent() const;
  /// The last component of the path that it was opened by.
  std::string name() const;
  ~Directory();
  Directory(Directory&& other) noexcept;
  Directory& operator=(Directory&& other) noexcept;

  bool is_open() const noexcept { return descriptor_ >= 0; }
  int descriptor() const noexcept { return descriptor_; }
  /// As it was opened, for messages: the directory may have another name by now.
  const std::filesystem::path& path() const noexcept { return path_; }
  std::filesystem::path path_of(const std::string& name) const { return path_ / name; }

  /// Whether there is an entry of that name, of whatever kind; a link is not followed.
  /// Errors: kIo.
  bool contains(const std::string& name) const;
  /// Whether the entry `name` of this directory is the directory `other`. Errors: kIo.
  bool contains(const std::string& name, const Directory& other) const;
  /// All names but "." and "..", sorted. Errors: kIo.
  std::vector<std::string> names() const;

  /// A file, a link or whatever else is no directory; one that is not there is no error.
  /// Errors: kIo.
  void remove(const std::string& name) const;
  /// For what is left over, and may stay so.
  void remove_if_possible(const std::string& name) const noexcept;
  /// False if the directory `name` is not empty, or is none. Errors: kIo.
  bool remove_directory(const std::string& name) const;

  /// Removes this directory under the name that it was opened by, if it still has it and is empty;
  /// false if not. Errors: kIo.
  bool remove_itself() const;

  /// Gives the entry `from` the name `to` in the directory `other`, on the same filesystem. False
  /// if `to` is taken (kRefuse). Where the filesystem cannot do it in one step, kRefuse looks
  /// first. Errors: kNotSupported where kExchange is not; kIo, kNoSpace.
  bool rename(const std::string& from, const Directory& other, const std::string& to,
              Renaming renaming = Renaming::kReplace) const;

  /// Makes the names in the directory durable. Errors: kIo.
  void sync() const;
  /// flock, as File::lock. Errors: kIo.
  bool lock(bool exclusive) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace plait
