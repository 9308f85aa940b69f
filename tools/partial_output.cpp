#include "partial_output.h"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <vector>

#include "console.h"
#include "left_overs.h"
#include "plait/error.h"
#include "plait/file.h"
#include "plait/store_directory.h"

namespace plait {
namespace {

Error taken(const std::filesystem::path& path, Existing existing) {
  if (existing == Existing::kRefuse)
    return {ErrorCode::kInvalidArgument,
            fmt::format("create {}: it exists, and --force was not given", path.native())};
  return {ErrorCode::kInvalidArgument,
          fmt::format("replace {}: expected a store, found something else", path.native())};
}

/// Opens a directory that may be replaced: one that is_store(), even if the store is damaged.
Directory open_replaceable(const Directory& parent, const std::string& name,
                           const std::filesystem::path& path) {
  try {
    Directory store(parent, name);
    if (is_store(store)) return store;
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument && error.code() != ErrorCode::kCorruption)
      throw;
  }
  throw taken(path, Existing::kReplace);
}

}  // namespace

PartialOutput::PartialOutput(const std::filesystem::path& final_path, Existing existing)
    : final_path_(final_path.lexically_normal()), existing_(existing) {
  OutputName output(final_path);
  parent_ = std::move(output.directory);
  name_ = std::move(output.name);
  if (!final_path_.has_filename()) final_path_ = final_path_.parent_path();
  if (parent_.contains(name_)) {
    if (existing_ == Existing::kRefuse) throw taken(final_path_, existing_);
    hold_store(open_replaceable(parent_, name_, final_path_));
  }
  remove_left_overs_of(final_path_);
}

PartialOutput::~PartialOutput() {
  if (partial_name_.empty()) return;
  try {
    remove_store_files(made_);
    if (parent_.contains(partial_name_, made_.descriptor()))
      parent_.remove_directory(partial_name_);
  } catch (const std::exception&) {  // the next run with this output removes it
  }
}

const std::filesystem::path& PartialOutput::make() {
  for (int attempt = 0;; ++attempt) {
    partial_name_ = temporary_name(name_, "partial", attempt);
    if (parent_.contains(partial_name_)) continue;
    path_ = final_path_;
    path_.replace_filename(partial_name_);
    made_ = Directory::make(path_);
    if (made_.lock(false) && parent_.contains(partial_name_, made_.descriptor())) return path_;
  }
}

void PartialOutput::publish(bool durable) {
  if (!parent_.contains(partial_name_, made_.descriptor())) {
    partial_name_.clear();
    throw Error(ErrorCode::kBadState,
                fmt::format("rename to {}: the new store is not at {} any more",
                            final_path_.native(), path_.native()));
  }
  if (!parent_.rename(partial_name_, parent_, name_, Renaming::kRefuse)) {
    if (existing_ == Existing::kRefuse) throw taken(final_path_, existing_);
    replace_store();
  }
  partial_name_.clear();
  if (durable) parent_.sync();
}

/// Removes the old store after the new one has its name. An old store that another process has open
/// stays.
void PartialOutput::replace_store() {
  const Directory replaced = open_replaceable(parent_, name_, final_path_);
  std::vector<File> held;
  try {
    held = hold_store(replaced);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kBusy) throw;
    stay_beside("it is in use");
  }
  parent_.rename(partial_name_, parent_, name_, Renaming::kExchange);
  if (!parent_.contains(partial_name_, replaced.descriptor())) {
    parent_.rename(partial_name_, parent_, name_, Renaming::kExchange);
    stay_beside("another one has its name");
  }
  parent_.sync();
  remove_store_files(replaced);
  keep_foreign(replaced);
  if (!parent_.remove_directory(partial_name_))
    report_warning(fmt::format("{}: parts of the replaced store stay there", path_.native()));
}

void PartialOutput::keep_foreign(const Directory& replaced) const {
  for (const std::string& name : replaced.names())
    if (replaced.rename(name, made_, name, Renaming::kRefuse))
      report_warning(
          fmt::format("{}: '{}' is no file of a store, and was kept", final_path_.native(), name));
}

/// Keeps the new store, which may be the work of hours, under a name that no run removes as left
/// over.
void PartialOutput::stay_beside(const std::string& why) {
  std::string kept;
  for (int attempt = 0;; ++attempt) {
    kept = temporary_name(name_, "complete", attempt);
    if (parent_.rename(partial_name_, parent_, kept, Renaming::kRefuse)) break;
  }
  partial_name_.clear();
  path_.replace_filename(kept);
  parent_.sync();
  throw Error(ErrorCode::kBusy,
              fmt::format("replace {}: {}; the new store is complete and stays at {}",
                          final_path_.native(), why, path_.native()));
}

}  // namespace plait
