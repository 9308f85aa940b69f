#include "plait/partial_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "plait/error.h"

namespace plait {
namespace {

Error taken(const std::filesystem::path& path) {
  return {ErrorCode::kInvalidArgument, fmt::format("create {}: it exists already", path.native())};
}

void refuse_what_is_there(const Directory& directory, const std::string& name,
                          const std::filesystem::path& path, Existing existing) {
  if (!directory.contains(name)) return;
  if (existing == Existing::kRefuse) throw taken(path);
  // A directory, or a device such as /dev/null, must not be replaced by a file.
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create {}: it exists and is no regular file", path.native()));
}

}  // namespace

std::string temporary_name(const std::string& name, const std::string& kind, int attempt) {
  std::string result = fmt::format("{}.{}-{}", name, kind, ::getpid());
  return attempt == 0 ? result : fmt::format("{}-{}", result, attempt);
}

OutputName::OutputName(const std::filesystem::path& path) {
  std::filesystem::path whole = path.lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  name = whole.filename();
  if (name.empty() || name == "." || name == "..")
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create \"{}\": expected a path that ends in a name", path.native()));
  const std::filesystem::path parent = whole.has_parent_path() ? whole.parent_path() : ".";
  try {
    directory = Directory(parent);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    throw Error(ErrorCode::kNotFound, fmt::format("create {}: there is no directory {}",
                                                  whole.native(), parent.native()));
  }
}

PartialFile::PartialFile(const std::filesystem::path& path, Existing existing)
    : path_(path), existing_(existing) {
  OutputName output(path);
  directory_ = std::move(output.directory);
  name_ = std::move(output.name);
  refuse_what_is_there(directory_, name_, path_, existing_);
  // Another thread may use the name, or a killed process with the same number may have left it. And
  // a program that removes left-over files may remove this one before it is locked; then a new
  // attempt makes another.
  for (int attempt = 0;; ++attempt) {
    partial_name_ = temporary_name(name_, "partial", attempt);
    if (directory_.contains(partial_name_)) continue;
    try {
      file_ = File(directory_, partial_name_, OpenMode::kCreate);
    } catch (const Error& error) {  // the user never gave this name: the message gets the final one
      std::string message = error.what();
      const std::string partial = directory_.path_of(partial_name_).native();
      if (const std::size_t at = message.find(partial); at != std::string::npos)
        message.replace(at, partial.size(), path_.native());
      throw Error(error.code(), message);
    }
    if (file_.lock(true) && directory_.contains(partial_name_, file_.descriptor())) return;
  }
}

void PartialFile::check(const std::filesystem::path& path, Existing existing) {
  const OutputName output(path);
  refuse_what_is_there(output.directory, output.name, path, existing);
}

PartialFile::~PartialFile() {
  if (!partial_name_.empty()) directory_.remove_if_possible(partial_name_);
}

void PartialFile::publish() {
  file_.sync();
  const Renaming renaming = existing_ == Existing::kRefuse ? Renaming::kRefuse : Renaming::kReplace;
  if (!directory_.rename(partial_name_, directory_, name_, renaming)) throw taken(path_);
  partial_name_.clear();
  file_.close();
  directory_.sync();
}

}  // namespace plait
