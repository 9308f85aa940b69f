#include "io/partial_output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <system_error>
#include <utility>

#include "io/made_mark.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Error name_taken(const std::filesystem::path& path) {
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("create {}: it exists already", path.native()))
      .about(path);
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

Error complete_under_its_name(const Error& error, const std::filesystem::path& path) {
  return {error.code(), fmt::format("{}: it is complete and has its name, but after a crash of the "
                                    "machine it may not have it any more: {}",
                                    path.native(), error.what())};
}

}  // namespace

void sync_name(const Directory& parent, const std::filesystem::path& path) {
  try {
    parent.sync();
  } catch (const Error& error) {
    throw complete_under_its_name(error, path);
  }
}

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

PartialDirectory::PartialDirectory(std::filesystem::path final_path, std::string kind,
                                   MadeProof proof, RemoveContent remove_content)
    : final_path_(std::move(final_path)),
      kind_(std::move(kind)),
      proof_(proof),
      remove_content_(remove_content) {}

PartialDirectory::~PartialDirectory() {
  if (!process_.is_current()) return;
  try {
    if (!made_.is_open() || !name_->is_of(made_.descriptor())) return;
    remove_content_(made_);
    if (proof_ == MadeProof::kMark) made_.remove(kMadeMarkName);
    name_->parent().remove_directory(name_->name());
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

const Directory& PartialDirectory::directory() {
  if (made_.is_open()) return made_;
  name_.emplace(final_path_, kind_);
  Directory made;
  // A program that removes left-overs may remove this directory before it is locked; then the next
  // attempt makes another one. The lock is a shared one because Store::create takes it too.
  do {
    name_->next();
    try {
      made = Directory::make(name_->path());
    } catch (const Error& error) {
      throw with_final_name(error, name_->path(), name_->final_path());
    }
  } while (!made.lock(false) || !name_->is_of(made.descriptor()));
  made_ = std::move(made);
  if (proof_ == MadeProof::kMark) try {
      write_made_mark(made_);
    } catch (const Error& error) {
      throw with_final_name(error, made_.path_of(kMadeMarkName), name_->final_path());
    }
  return made_;
}

bool PartialDirectory::publish(bool durable) {
  if (durable) made_.sync();
  if (!name_->give(made_.descriptor(), name_->final_name(), Renaming::kRefuse)) return false;
  if (durable) sync_name(name_->parent(), final_path_);
  return true;
}

std::filesystem::path PartialDirectory::keep_as(std::string kind) {
  TemporaryName kept(final_path_, std::move(kind));
  while (!name_->give(made_.descriptor(), kept.next(), Renaming::kRefuse)) {
  }
  name_->parent().sync();
  return kept.path();
}

namespace {

constexpr char kOutputName[] = "output";

void remove_nothing(const Directory&) {}

}  // namespace

PartialFile::PartialFile(const std::filesystem::path& path, Existing existing)
    : existing_(existing),
      made_(OutputName(path).path, "partial", MadeProof::kMark, remove_nothing) {
  check(path, existing_);
  const Directory& directory = made_.directory();
  try {
    file_ = File(directory, kOutputName, OpenMode::kCreate);
  } catch (const Error& error) {
    throw with_final_name(error, directory.path_of(kOutputName), final_path());
  }
}

void PartialFile::check(const std::filesystem::path& path, Existing existing) {
  const OutputName output(path);
  refuse_what_is_there(output.directory, output.name, output.path, existing);
}

bool PartialFile::has_its_name() const {
  return made_.made().contains(kOutputName, file_.descriptor());
}

PartialFile::~PartialFile() {
  if (!process_.is_current()) return;
  try {
    if (file_.is_open() && has_its_name()) made_.made().remove(kOutputName);
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

void PartialFile::publish() {
  file_.sync();
  if (!has_its_name())
    throw Error(ErrorCode::kBadState,
                fmt::format("rename to {}: the new output is not at {} any more",
                            final_path().native(), path().native()));
  const Directory& parent = made_.name().parent();
  const Renaming renaming = existing_ == Existing::kRefuse ? Renaming::kRefuse : Renaming::kReplace;
  if (!made_.made().rename(kOutputName, parent, made_.name().final_name(), renaming))
    throw name_taken(final_path());
  try {
    file_.close();
    parent.sync();
  } catch (const Error& error) {
    throw complete_under_its_name(error, final_path());
  }
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
