#include "export/output_files.h"

#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>

#include "store/left_overs.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

bool begins_with(const std::filesystem::path& path, const std::string& mark) {
  std::error_code error;
  if (!is_regular_file(symlink_status(path, error))) return false;
  std::string found(mark.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(found.data(), static_cast<std::streamsize>(found.size()));
  return file && found == mark;
}

}  // namespace

OutputFiles::OutputFiles(const std::filesystem::path& path, Existing existing, Warn warn)
    : existing_(existing), warn_(std::move(warn)) {
  begin(path);
  path_ = files_.front().final_path();
}

File& OutputFiles::begin(const std::filesystem::path& path) {
  UnpublishedFile::check(path, existing_);
  remove_left_overs_of(path, warn_);
  return files_.emplace_back(path, existing_).file();
}

std::string OutputFiles::name_of(const std::string& ending) const {
  return path_.stem().string() + ending;
}

File& OutputFiles::add(const std::string& ending) {
  return begin(path_.parent_path() / name_of(ending));
}

void OutputFiles::remove_older(const std::string& ending, const std::string& mark) {
  if (existing_ == Existing::kReplace)
    older_.push_back({path_.parent_path() / name_of(ending), mark});
}

Error OutputFiles::named(Error error) const {
  for (const UnpublishedFile& file : files_)
    error = with_final_name(error, file.path(), file.final_path());
  return error;
}

void OutputFiles::publish() {
  for (UnpublishedFile& file : files_) file.file().sync();
  while (!files_.empty()) {
    try {
      files_.back().publish();
    } catch (const Error& error) {
      files_.pop_back();
      std::string message = error.what();
      for (UnpublishedFile& file : files_)
        message += fmt::format("; {} is complete and stays at {}", file.final_path().native(),
                               file.keep().native());
      throw Error(error.code(), message).about(path_);
    }
    files_.pop_back();
  }
  for (const Older& each : older_) {
    std::error_code error;
    if (begins_with(each.path, each.mark) && !std::filesystem::remove(each.path, error))
      warn_(fmt::format("remove {}, which an earlier export made: {}", each.path.native(),
                        error.message()));
  }
}

PLAIT_END_NAMESPACE
