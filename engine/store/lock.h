// One writer or many readers of a store.
#pragma once

#include <filesystem>

#include "plait/file.h"

namespace plait {

/// Holds the store's lock until destroyed. It is a lock of the open file (flock), so that it also
/// tells two opens of one process apart and ends with its holder, however that ends; the record
/// locks behind Boost.Interprocess file_lock do neither.
class StoreLock {
 public:
  StoreLock() = default;
  /// Errors: kBusy, of a writer with its process number; kIo.
  StoreLock(const std::filesystem::path& path, bool exclusive, bool create);

 private:
  void take(const std::filesystem::path& path, bool exclusive);
  void check_name(const std::filesystem::path& path) const;
  void write_holder();

  File file_;
};

}  // namespace plait
