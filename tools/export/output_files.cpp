#include "export/output_files.h"

#include "console.h"
#include "store/left_overs.h"

namespace plait {

OutputFiles::OutputFiles(const std::filesystem::path& path) {
  begin(path);
  path_ = files_.front().final_path();
}

File& OutputFiles::begin(const std::filesystem::path& path) {
  PartialFile::check(path, Existing::kReplace);
  remove_left_overs_of(path, report_warning);
  return files_.emplace_back(path, Existing::kReplace).file();
}

std::string OutputFiles::name_of(const std::string& ending) const {
  return path_.stem().string() + ending;
}

File& OutputFiles::add(const std::string& ending) {
  return begin(path_.parent_path() / name_of(ending));
}

Error OutputFiles::named(Error error) const {
  for (const PartialFile& file : files_)
    error = with_final_name(error, file.path(), file.final_path());
  return error;
}

void OutputFiles::publish() {
  while (!files_.empty()) {
    files_.back().publish();
    files_.pop_back();
  }
}

}  // namespace plait
