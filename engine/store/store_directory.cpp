#include "store/store_directory.h"

#include <utility>

#include "format/file_names.h"
#include "format/manifest.h"
#include "io/made_mark.h"
#include "plait/error.h"
#include "store/lock.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

bool is_store(const Directory& directory) { return has_whole_slot(directory); }

std::vector<File> hold_store(const Directory& store) {
  std::vector<File> held;
  try {
    held.push_back(StoreLock(store, LockFor::kMaintaining).release());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kNotFound) throw;
    return held;
  }
  for (File& version : keep_all_readers_out(store)) held.push_back(std::move(version));
  return held;
}

bool is_store_file_name(std::string_view name) {
  return is_version_file_name(name) || is_bounds_file_name(name) || is_base_index_name(name) ||
         is_viewer_file_name(name) || name == kBaseMeshName || name == kDepthsName ||
         name == kLockName || name == kManifestName || name == kKeptMarkName;
}

std::vector<std::string> remove_store_files(const Directory& store) {
  for (const std::string& name : store.names())
    if (is_store_file_name(name) && name != kLockName && name != kManifestName)
      store.remove_if_possible(name);
  for (const char* name : {kLockName, kManifestName}) store.remove_if_possible(name);
  return store.names();
}

PLAIT_END_NAMESPACE
