#include "store/unpublished_store.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/left_overs.h"
#include "store/store_directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Error store_name_taken(const std::filesystem::path& path, Existing existing) {
  if (existing == Existing::kRefuse)
    return Error(ErrorCode::kInvalidArgument,
                 fmt::format("create {}: it exists already", path.native()))
        .about(path);
  return Error(ErrorCode::kInvalidArgument,
               fmt::format("replace {}: expected a store, found something else", path.native()))
      .about(path);
}

/// Opens a directory that may be replaced: one that is_store(), even if the store is damaged.
Directory open_replaceable(const OutputName& output) {
  try {
    Directory store(output.directory, output.name);
    if (is_store(store)) return store;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument && error.code() != ErrorCode::kCorruption)
      throw;
  }
  throw store_name_taken(output.path, Existing::kReplace);
}

void check_name(const OutputName& output, Existing existing) {
  if (!output.directory.contains(output.name)) return;
  if (existing == Existing::kRefuse) throw store_name_taken(output.path, existing);
  hold_store(open_replaceable(output));
}

}  // namespace

UnpublishedStore::UnpublishedStore(const std::filesystem::path& final_path, Existing existing,
                                   Warn warn)
    : output_(final_path),
      existing_(existing),
      warn_(std::move(warn)),
      made_(output_.path, "partial", MadeProof::kManifest, remove_made_files) {
  check_name(output_, existing_);
  remove_left_overs_of(output_.path, warn_);
}

void UnpublishedStore::check(const std::filesystem::path& final_path, Existing existing) {
  check_name(OutputName(final_path), existing);
}

const std::filesystem::path& UnpublishedStore::make() {
  made_.directory();
  path_ = made_.name().path();
  if (existing_ == Existing::kReplace && output_.directory.contains(output_.name)) try_replacing();
  return path_;
}

/// Tries before the work what publish() will need: that the old store can get another name, and
/// whether names can be exchanged.
void UnpublishedStore::try_replacing() {
  const Directory& parent = output_.directory;
  UnpublishedDirectory other(output_.path, "partial", MadeProof::kMark, [](const Directory&) {});
  other.directory();
  const std::string& taken = other.name().name();
  try {
    // The mark is in that directory, so the renaming must fail; if a file system does it, back.
    if (parent.rename(output_.name, parent, taken)) parent.rename(taken, parent, output_.name);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotSupported)
      throw Error(error.code(),
                  fmt::format("replace {}: the old store can have no other name, as in a lower "
                              "layer of an overlay (an image of a container) or at a mount point "
                              "({}): remove it before, or give the new store another name",
                              final_path().native(), error.what()))
          .about(final_path());
  }
  can_exchange_ = can_exchange_names(other.name());
  if (!can_exchange_)
    tell(
        fmt::format("{}: its file system cannot exchange two names: for a moment there will be no "
                    "store of this name",
                    final_path().native()));
}

/// Exchanges the new directory with another one, and back.
bool UnpublishedStore::can_exchange_names(UnfinishedName& other) {
  const Directory& parent = output_.directory;
  const std::string& name = made_.name().name();
  const auto exchange = [&] { parent.rename(name, parent, other.name(), Renaming::kExchange); };
  try {
    exchange();
  } catch (const Error&) {
    return false;
  }
  exchange();
  return true;
}

void UnpublishedStore::publish(bool durable) {
  try {
    give_name(durable);
  } catch (const Error& error) {
    // kBadState: another process has taken the directory away.
    if (has_final_name_ || made_.has_final_name() || error.code() == ErrorCode::kBadState) throw;
    path_ = made_.keep();
    throw Error(error.code(), fmt::format("{}; the new store is complete and stays at {}",
                                          error.what(), path_.native()))
        .about(final_path());
  }
}

void UnpublishedStore::give_name(bool durable) {
  if (made_.publish(durable)) return;
  if (existing_ == Existing::kRefuse) throw store_name_taken(final_path(), existing_);
  replace_store();
  if (durable) sync_name(output_.directory, final_path());
}

/// Removes the old store after the new one has its name. An old store that another process has open
/// stays.
void UnpublishedStore::replace_store() {
  const auto busy = [&](const char* why) {
    return Error(ErrorCode::kBusy, fmt::format("replace {}: {}", final_path().native(), why));
  };
  const Directory replaced = open_replaceable(output_);
  std::vector<File> held;
  try {
    held = hold_store(replaced);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBusy) throw;
    throw busy("another process uses or replaces it");
  }
  const std::string old_name = can_exchange_ ? exchange_names(replaced) : rename_twice(replaced);
  if (old_name.empty()) throw busy("another process has replaced the store meanwhile");
  has_final_name_ = true;
  sync_name(output_.directory, final_path());
  remove_left_overs_of_repairs(replaced, {});
  // Before the manifest goes, which shows that the rest is a store.
  for (const std::string& name : replaced.names())
    if (!is_store_file_name(name) &&
        replaced.rename(name, made_.directory(), name, Renaming::kRefuse))
      tell(fmt::format("{}: '{}' is not a file of a store, so it stays", final_path().native(),
                       name));
  remove_store_files(replaced);
  if (!output_.directory.remove_directory(old_name))
    tell(fmt::format("{}: parts of the replaced store stay there",
                     output_.directory.path_of(old_name).lexically_normal().native()));
}

std::string UnpublishedStore::exchange_names(const Directory& replaced) {
  try {
    const std::string name = made_.name().name();
    return made_.name().exchange(made_.directory().descriptor(), replaced.descriptor())
               ? name
               : std::string();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotSupported) throw;
    return rename_twice(replaced);
  }
}

std::string UnpublishedStore::rename_twice(const Directory& replaced) {
  const Directory& parent = output_.directory;
  UnfinishedName aside(output_.path, "replaced");
  while (!parent.rename(output_.name, parent, aside.next(), Renaming::kRefuse)) {
  }
  const auto put_back = [&] {
    return parent.rename(aside.name(), parent, output_.name, Renaming::kRefuse);
  };
  if (!parent.contains(aside.name(), replaced.descriptor())) {
    put_back();
    return {};
  }
  try {
    if (made_.name().give(made_.directory().descriptor(), output_.name, Renaming::kRefuse))
      return aside.name();
  } catch (const Error&) {
    put_back();
    throw;
  }
  throw Error(ErrorCode::kBusy, fmt::format("replace {}: another process has taken the name "
                                            "meanwhile; the old store is at {}",
                                            final_path().native(), aside.path().native()));
}

PLAIT_END_NAMESPACE
