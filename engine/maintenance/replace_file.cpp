#include "maintenance/replace_file.h"

#include <fmt/format.h>

#include <vector>

#include "format/manifest.h"
#include "plait/error.h"
#include "plait/extend/file.h"
#include "store/recovery.h"
#include "store/version_locks.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

void replace_file(const std::filesystem::path& path, std::uint64_t sequence,
                  const std::string& name, const Directory& from_directory,
                  const std::string& from) {
  const Directory store = open_store_directory(path);
  const StoreLock lock = lock_for_writing(store, Durability::kCommit);
  // A reader locks the very file that may be replaced.
  const std::vector<File> alone = keep_all_readers_out(store);
  if (const std::uint64_t found = read_manifest(store).sequence; found != sequence)
    throw Error(
        ErrorCode::kBusy,
        fmt::format("replace {}: it is of version {}, and somebody has committed version {}",
                    store.path_of(name).native(), sequence, found));
  File file(from_directory, from, OpenMode::kReadWrite);
  file.sync();
  file.close();
  from_directory.rename(from, store, name);
  store.sync();
}

PLAIT_END_NAMESPACE
