#include "io/unpublished.h"

#include <fmt/format.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "io/locks.h"
#include "io/machine.h"
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
  // The new file would take the place of the link, and who reads by another name reads the old one.
  if (std::filesystem::is_symlink(path, ignored))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("create {}: it is a symbolic link: expected the name of the file itself",
                    path.native()));
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

Directory make_locked_directory(const std::function<std::filesystem::path()>& next,
                                bool exclusive) {
  // Other processes interfere a few times at most. Where a directory cannot be made, as in /proc,
  // the error is the same as that of a race.
  constexpr int kMostAttempts = 100;
  for (int attempt = 1;; ++attempt) {
    const std::filesystem::path path = next();
    const std::filesystem::path above = path.has_parent_path() ? path.parent_path() : ".";
    Directory made;
    try {
      made = Directory::make(path);
    } catch (const Error& error) {
      std::error_code ignored;
      if (error.code() != ErrorCode::kNotFound || attempt == kMostAttempts ||
          !std::filesystem::is_directory(above, ignored))
        throw;
      continue;  // another process removed it before it was open
    }
    if (try_lock(made, exclusive) != LockResult::kConflict &&
        Directory(above).contains(path.filename(), made.descriptor()))
      return made;
    if (attempt == kMostAttempts)
      throw Error(ErrorCode::kBusy,
                  fmt::format("create {}: other processes make and remove it", path.native()))
          .about(path);
  }
}

namespace {

/// Those that no run removes are not unfinished.
constexpr std::string_view kUnfinishedKinds[] = {"partial", "repair", "replaced"};

bool is_digits(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789-") == std::string_view::npos;
}

}  // namespace

std::optional<UnfinishedNameParts> read_unfinished_name(std::string_view name) {
  UnfinishedNameParts parts;
  std::string_view machine;
  for (const std::string_view kind : kUnfinishedKinds) {
    const std::size_t dot = name.rfind(fmt::format(".{}-", kind));
    if (dot == std::string_view::npos || dot == 0 || dot < parts.stem.size()) continue;
    parts.stem = name.substr(0, dot);
    parts.kind = kind;
    machine = name.substr(dot + kind.size() + 2);
  }
  if (parts.stem.empty()) return std::nullopt;
  if (is_digits(machine)) return parts;
  const std::optional<Maker> maker = read_maker(machine);
  if (!maker) return std::nullopt;
  static_cast<Maker&>(parts) = *maker;
  return parts;
}

bool may_be_in_use(const Directory& directory, const Maker& maker) {
  const LockResult lock = try_lock(directory, true);
  const OwnMachine& own = own_machine();
  if (lock == LockResult::kConflict || (!maker.host.empty() && maker.host != own.host)) return true;
  if (lock == LockResult::kTaken && locks_are_seen_by_all(directory.descriptor())) return false;
  return maker.start != own.start || !has_ended(maker.process);
}

UnfinishedName::UnfinishedName(const std::filesystem::path& final_path, std::string kind)
    : output_(final_path), kind_(std::move(kind)) {}

std::string UnfinishedName::stem_of(const std::string& final_name) const {
  // ".complete-HOST-START-PROCESS.RANDOM" has at most 92 bytes.
  constexpr std::size_t kRoom = 96, kUsualLimit = 255;
  const long limit = ::fpathconf(parent().descriptor(), _PC_NAME_MAX);
  const std::size_t most = limit > 0 ? static_cast<std::size_t>(limit) : kUsualLimit;
  if (final_name.size() + kRoom <= most || most <= kRoom) return final_name;
  const std::string hash =
      fmt::format("~{:016x}", XXH3_64bits(final_name.data(), final_name.size()));
  std::size_t kept = most - kRoom - std::min(most - kRoom, hash.size());
  // Between two characters of UTF-8.
  while (kept > 0 && (static_cast<unsigned char>(final_name[kept]) & 0xc0u) == 0x80u) --kept;
  return final_name.substr(0, kept) + hash;
}

const std::string& UnfinishedName::next() {
  do name_ = fmt::format("{}.{}-{}", stem_of(final_name()), kind_, new_maker_name());
  while (parent().contains(name_));
  return name_;
}

bool UnfinishedName::is_of(int descriptor) const {
  return !name_.empty() && parent().contains(name_, descriptor);
}

void UnfinishedName::require(int descriptor, const std::string& to) {
  if (is_of(descriptor)) return;
  const std::filesystem::path expected = path();
  name_.clear();
  throw Error(ErrorCode::kBadState,
              fmt::format("rename to {}: the new output is not at {} any more",
                          parent().path_of(to).lexically_normal().native(), expected.native()));
}

bool UnfinishedName::give(int descriptor, const std::string& to, Renaming renaming) {
  require(descriptor, to);
  if (!parent().rename(name_, parent(), to, renaming)) return false;
  name_.clear();
  return true;
}

bool UnfinishedName::exchange(int descriptor, int other) {
  require(descriptor, final_name());
  parent().rename(name_, parent(), final_name(), Renaming::kExchange);
  if (is_of(other)) return true;
  parent().rename(name_, parent(), final_name(), Renaming::kExchange);
  return false;
}

UnpublishedDirectory::UnpublishedDirectory(std::filesystem::path final_path, std::string kind,
                                           MadeProof proof, RemoveContent remove_content)
    : final_path_(std::move(final_path)),
      kind_(std::move(kind)),
      proof_(proof),
      remove_content_(remove_content) {}

UnpublishedDirectory::~UnpublishedDirectory() {
  if (is_kept_ || !process_.is_current()) return;
  try {
    if (!made_.is_open() || !name_->is_of(made_.descriptor())) return;
    remove_content_(made_);
    if (proof_ == MadeProof::kMark) made_.remove(kMadeMarkName);
    name_->parent().remove_directory(name_->name());
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

const Directory& UnpublishedDirectory::directory() {
  if (made_.is_open()) return made_;
  name_.emplace(final_path_, kind_);
  // The lock is a shared one because Store::create takes it too.
  try {
    made_ = make_locked_directory(
        [&] {
          name_->next();
          return name_->path();
        },
        false);
  } catch (const Error& error) {
    throw with_final_name(error, name_->path(), name_->final_path());
  }
  if (proof_ == MadeProof::kMark) try {
      write_made_mark(made_);
    } catch (const Error& error) {
      throw with_final_name(error, made_.path_of(kMadeMarkName), name_->final_path());
    }
  return made_;
}

bool UnpublishedDirectory::publish(bool durable) {
  if (durable) made_.sync();
  if (!name_->give(made_.descriptor(), name_->final_name(), Renaming::kRefuse)) return false;
  has_final_name_ = true;
  // Not before: without the mark, nobody would remove what a killed process leaves.
  if (proof_ == MadeProof::kMark) made_.remove_if_possible(kMadeMarkName);
  if (durable) sync_name(name_->parent(), final_path_);
  return true;
}

std::filesystem::path UnpublishedDirectory::keep() noexcept {
  is_kept_ = true;
  std::filesystem::path path = name_->path();
  try {
    UnfinishedName kept(final_path_, "complete");
    while (!name_->give(made_.descriptor(), kept.next(), Renaming::kRefuse)) {
    }
    path = kept.path();
    name_->parent().sync();
  } catch (const std::exception&) {  // it stays under its unfinished name, or unsynced
  }
  // Without its proof it is no left-over of a killed run; the manifest of a store must stay.
  if (proof_ == MadeProof::kMark)
    made_.remove_if_possible(kMadeMarkName);
  else if (!name_->name().empty())
    try {
      write_kept_mark(made_);
    } catch (const std::exception&) {  // a later run may remove it
    }
  return path;
}

namespace {

constexpr char kOutputName[] = "output";

void remove_nothing(const Directory&) {}

}  // namespace

UnpublishedFile::UnpublishedFile(const std::filesystem::path& path, Existing existing)
    : existing_(existing),
      made_(OutputName(path).path, "partial", MadeProof::kMark, remove_nothing) {
  check(path, existing_);
}

File& UnpublishedFile::file() {
  if (file_.is_open()) return file_;
  const Directory& directory = made_.directory();
  try {
    file_ = File(directory, kOutputName, OpenMode::kCreate);
  } catch (const Error& error) {
    throw with_final_name(error, directory.path_of(kOutputName), final_path());
  }
  return file_;
}

void UnpublishedFile::check(const std::filesystem::path& path, Existing existing) {
  const OutputName output(path);
  refuse_what_is_there(output.directory, output.name, output.path, existing);
}

bool UnpublishedFile::has_its_name() const {
  return made_.made().contains(kOutputName, file_.descriptor());
}

UnpublishedFile::~UnpublishedFile() {
  if (!process_.is_current()) return;
  try {
    if (file_.is_open() && !is_kept_ && has_its_name()) made_.made().remove(kOutputName);
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

void UnpublishedFile::publish() {
  file_.sync();
  if (!has_its_name())
    throw Error(ErrorCode::kBadState,
                fmt::format("rename to {}: the new output is not at {} any more",
                            final_path().native(), path().native()));
  const Directory& parent = made_.name().parent();
  const Renaming renaming = existing_ == Existing::kRefuse ? Renaming::kRefuse : Renaming::kReplace;
  try {
    if (!made_.made().rename(kOutputName, parent, made_.name().final_name(), renaming))
      throw name_taken(final_path());
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}; the new file is complete and stays at {}",
                                          error.what(), keep().native()));
  }
  try {
    file_.close();
    parent.sync();
  } catch (const Error& error) {
    throw complete_under_its_name(error, final_path());
  }
}

std::filesystem::path UnpublishedFile::keep() noexcept {
  is_kept_ = true;
  const Directory& parent = made_.name().parent();
  std::filesystem::path path;
  try {
    UnfinishedName kept(final_path(), "complete");
    while (!made_.made().rename(kOutputName, parent, kept.next(), Renaming::kRefuse)) {
    }
    path = kept.path();
    parent.sync();
  } catch (const std::exception&) {  // it stays in its directory, or unsynced
  }
  return path.empty() ? made_.keep() / kOutputName : path;
}

std::string with_final_name(std::string text, const std::filesystem::path& unfinished,
                            const std::filesystem::path& final_path) {
  if (unfinished.empty()) return text;  // the program has not made the output yet
  for (std::size_t at = 0; (at = text.find(unfinished.native(), at)) != std::string::npos;) {
    text.replace(at, unfinished.native().size(), final_path.native());
    at += final_path.native().size();
  }
  return text;
}

Error with_final_name(const Error& error, const std::filesystem::path& unfinished,
                      const std::filesystem::path& final_path) {
  Error named(error, with_final_name(error.what(), unfinished, final_path));
  if (error.path().empty()) return named;
  return named.about(with_final_name(error.path().native(), unfinished, final_path),
                     error.offset());
}

PLAIT_END_NAMESPACE
