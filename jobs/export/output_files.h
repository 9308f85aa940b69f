// export/output_files.h: the files of one export. Each is made under a temporary name. They get
// their names when all are complete, and the file that names the others gets its name last.
#pragma once

#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/unpublished.h"
#include "plait/detail/namespace.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// For one thread. The destructor removes what was not published.
class OutputFiles {
 public:
  using Warn = std::function<void(const std::string&)>;

  /// Calls `warn` for each left-over of a killed run that it removes. Errors: those of
  /// UnpublishedFile.
  OutputFiles(const std::filesystem::path& path, Existing existing, Warn warn);

  File& main() noexcept { return files_.front().file(); }
  /// The final one of the main file.
  const std::filesystem::path& path() const noexcept { return path_; }
  /// A file beside the main one whose name is that of the main one with `ending` in place of its
  /// extension. Errors: those of UnpublishedFile.
  File& add(const std::string& ending);
  /// The name of this file, without a directory.
  std::string name_of(const std::string& ending) const;

  /// With Existing::kReplace: when the files have their names, the file that add(`ending`) would
  /// replace is removed if it begins with `mark`, which only this program writes: it belongs to an
  /// earlier export.
  void remove_older(const std::string& ending, const std::string& mark);

  /// `error` with the final names of the files.
  Error named(Error error) const;
  /// If a file cannot get its name, it and those after it stay under names that the error tells.
  /// Errors: those of UnpublishedFile::publish. Only warns if an older file cannot be removed.
  void publish();

 private:
  /// Removes what killed exports have left of this file, and begins it.
  File& begin(const std::filesystem::path& path);

  struct Older {
    std::filesystem::path path;
    std::string mark;
  };
  Existing existing_;
  Warn warn_;
  std::deque<UnpublishedFile> files_;
  std::filesystem::path path_;
  std::vector<Older> older_;
};

PLAIT_END_NAMESPACE
