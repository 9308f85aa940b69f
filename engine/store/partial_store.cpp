#include "store/partial_store.h"

#include <fmt/format.h>

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

PartialStore::PartialStore(const std::filesystem::path& final_path, Existing existing)
    : output_(final_path),
      existing_(existing),
      made_(output_.path, "partial", MadeProof::kManifest, remove_made_files) {
  check_name(output_, existing_);
}

void PartialStore::check(const std::filesystem::path& final_path, Existing existing) {
  check_name(OutputName(final_path), existing);
}

const std::filesystem::path& PartialStore::make() {
  made_.directory();
  path_ = made_.name().path();
  return path_;
}

void PartialStore::publish(bool durable, const std::function<void(const std::string&)>& warn) {
  if (made_.publish(durable)) return;
  if (existing_ == Existing::kRefuse) throw store_name_taken(final_path(), existing_);
  replace_store(warn);
  if (durable) sync_name(output_.directory, final_path());
}

/// Removes the old store after the new one has its name. An old store that another process has open
/// stays.
void PartialStore::replace_store(const std::function<void(const std::string&)>& warn) {
  const Directory replaced = open_replaceable(output_);
  std::vector<File> held;
  try {
    held = hold_store(replaced);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBusy) throw;
    stay_beside("another process uses or replaces it");
  }
  TemporaryName& temporary = made_.name();
  if (!temporary.exchange(made_.directory().descriptor(), replaced.descriptor()))
    stay_beside("another process has replaced the store meanwhile");
  sync_name(output_.directory, final_path());
  const auto tell = [&](const std::string& what) {
    if (warn) warn(what);
  };
  // Before the manifest goes, which shows that the rest is a store.
  for (const std::string& name : replaced.names())
    if (!is_store_file_name(name) &&
        replaced.rename(name, made_.directory(), name, Renaming::kRefuse))
      tell(fmt::format("{}: '{}' is not a file of a store, so it stays", final_path().native(),
                       name));
  remove_store_files(replaced);
  if (!output_.directory.remove_directory(temporary.name()))
    tell(fmt::format("{}: parts of the replaced store stay there", path_.native()));
}

/// Keeps the new store, which may be the work of hours, under a name that no run removes as left
/// over.
void PartialStore::stay_beside(const std::string& why) {
  path_ = made_.keep_as("complete");
  throw Error(ErrorCode::kBusy,
              fmt::format("replace {}: {}; the new store is complete and stays at {}",
                          final_path().native(), why, path_.native()));
}

PLAIT_END_NAMESPACE
