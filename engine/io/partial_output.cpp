#include "plait/partial_output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Error name_taken(const std::filesystem::path& path) {
  return {ErrorCode::kInvalidArgument, fmt::format("create {}: it exists already", path.native())};
}

void refuse_what_is_there(const Directory& directory, const std::string& name,
                          const std::filesystem::path& path, Existing existing) {
  if (!directory.contains(name)) return;
  if (existing == Existing::kRefuse) throw name_taken(path);
  // A directory, or a device such as /dev/null, must not be replaced by a file.
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create {}: it exists and is no regular file", path.native()));
}

}  // namespace

OutputName::OutputName(const std::filesystem::path& given) : path(given.lexically_normal()) {
  if (!path.has_filename()) path = path.parent_path();
  name = path.filename();
  if (name.empty() || name == "." || name == "..")
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("create \"{}\": expected a path that ends in a name", given.native()));
  const std::filesystem::path parent = path.has_parent_path() ? path.parent_path() : ".";
  try {
    directory = Directory(parent);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    throw Error(ErrorCode::kNotFound,
                fmt::format("create {}: there is no directory {}", path.native(), parent.native()));
  }
}

TemporaryName::TemporaryName(const std::filesystem::path& final_path, std::string kind)
    : output_(final_path), kind_(std::move(kind)) {}

const std::string& TemporaryName::next() {
  do {
    name_ = fmt::format("{}.{}-{}", final_name(), kind_, ::getpid());
    if (attempt_ > 0) name_ += fmt::format("-{}", attempt_);
    ++attempt_;
  } while (parent().contains(name_));
  return name_;
}

bool TemporaryName::is_of(int descriptor) const {
  return !name_.empty() && parent().contains(name_, descriptor);
}

void TemporaryName::require(int descriptor, const std::string& to) {
  if (is_of(descriptor)) return;
  const std::filesystem::path expected = path();
  name_.clear();
  throw Error(ErrorCode::kBadState,
              fmt::format("rename to {}: the new output is not at {} any more",
                          parent().path_of(to).lexically_normal().native(), expected.native()));
}

bool TemporaryName::give(int descriptor, const std::string& to, Renaming renaming) {
  require(descriptor, to);
  if (!parent().rename(name_, parent(), to, renaming)) return false;
  name_.clear();
  return true;
}

bool TemporaryName::exchange(int descriptor, int other) {
  require(descriptor, final_name());
  parent().rename(name_, parent(), final_name(), Renaming::kExchange);
  if (is_of(other)) return true;
  parent().rename(name_, parent(), final_name(), Renaming::kExchange);
  return false;
}

PartialFile::PartialFile(const std::filesystem::path& path, Existing existing)
    : existing_(existing), name_(path, "partial") {
  refuse_what_is_there(name_.parent(), name_.final_name(), final_path(), existing_);
  // A program that removes left-overs may remove this file before it is locked; then the next
  // attempt makes another one.
  do {
    const std::string& name = name_.next();
    try {
      file_ = File(name_.parent(), name, OpenMode::kCreate);
    } catch (const Error& error) {
      throw with_final_name(error, name_.parent().path_of(name), final_path());
    }
  } while (!file_.lock(true) || !name_.is_of(file_.descriptor()));
}

void PartialFile::check(const std::filesystem::path& path, Existing existing) {
  const OutputName output(path);
  refuse_what_is_there(output.directory, output.name, output.path, existing);
}

PartialFile::~PartialFile() {
  try {
    if (name_.is_of(file_.descriptor())) name_.parent().remove(name_.name());
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

void PartialFile::publish() {
  file_.sync();
  const Renaming renaming = existing_ == Existing::kRefuse ? Renaming::kRefuse : Renaming::kReplace;
  if (!name_.give(file_.descriptor(), name_.final_name(), renaming)) throw name_taken(final_path());
  file_.close();
  name_.parent().sync();
}

PartialDirectory::PartialDirectory(std::filesystem::path final_path, std::string kind,
                                   RemoveContent remove_content)
    : final_path_(std::move(final_path)), kind_(std::move(kind)), remove_content_(remove_content) {}

PartialDirectory::~PartialDirectory() {
  try {
    if (!made_.is_open() || !name_->is_of(made_.descriptor())) return;
    remove_content_(made_);
    name_->parent().remove_directory(name_->name());
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

const Directory& PartialDirectory::directory() {
  if (made_.is_open()) return made_;
  name_.emplace(final_path_, kind_);
  Directory made;
  // As above. The lock is a shared one because Store::create takes it too.
  do {
    name_->next();
    try {
      made = Directory::make(name_->path());
    } catch (const Error& error) {
      throw with_final_name(error, name_->path(), name_->final_path());
    }
  } while (!made.lock(false) || !name_->is_of(made.descriptor()));
  made_ = std::move(made);
  return made_;
}

bool PartialDirectory::publish(bool durable) {
  if (durable) made_.sync();
  if (!name_->give(made_.descriptor(), name_->final_name(), Renaming::kRefuse)) return false;
  if (durable) name_->parent().sync();
  return true;
}

std::filesystem::path PartialDirectory::keep_as(std::string kind) {
  TemporaryName kept(final_path_, std::move(kind));
  while (!name_->give(made_.descriptor(), kept.next(), Renaming::kRefuse)) {
  }
  name_->parent().sync();
  return kept.path();
}

Error with_final_name(const Error& error, const std::filesystem::path& temporary,
                      const std::filesystem::path& final_path) {
  if (temporary.empty()) return error;  // the program has not made the output yet
  std::string message = error.what();
  for (std::size_t at = 0; (at = message.find(temporary.native(), at)) != std::string::npos;) {
    message.replace(at, temporary.native().size(), final_path.native());
    at += final_path.native().size();
  }
  return {error.code(), message};
}

PLAIT_END_NAMESPACE
