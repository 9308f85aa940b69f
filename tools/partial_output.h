// tools/partial_output.h: nothing half-made is left. A file or a store is built under a temporary
// name beside its final one and takes that name when it is whole.
#pragma once

#include <cstdint>
#include <filesystem>

#include "plait/backend.h"

namespace plait {

enum class Existing : std::uint8_t {
  kRefuse,        ///< what is there stays; kInvalidArgument
  kReplaceFile,   ///< a regular file goes when the new one is whole, and not before
  kReplaceStore,  ///< likewise a directory; see require_replaceable_store
};

/// The destructor removes what was not published.
class PartialOutput {
 public:
  /// Errors: kNotFound if the directory to put it into is not there; kInvalidArgument if the name
  /// is taken by what `existing` does not let go.
  PartialOutput(const std::filesystem::path& final_path, Existing existing);
  ~PartialOutput();
  PartialOutput(const PartialOutput&) = delete;
  PartialOutput& operator=(const PartialOutput&) = delete;

  /// Where to build: NAME.partial-PID. Nothing is there yet.
  const std::filesystem::path& path() const { return path_; }
  const std::filesystem::path& final_path() const { return final_path_; }

  /// Renames; `durable` also syncs the directory. What was replaced is removed.
  /// Errors: kInvalidArgument if the name was taken meanwhile; kBusy if somebody has opened the
  /// store to be replaced, and then path() stays; kIo, kNoSpace.
  void publish(bool durable);

 private:
  void replace_store(bool durable);
  void sync_name() const;

  std::filesystem::path final_path_, path_;
  Existing existing_;
  bool published_ = false;
};

/// What --force may replace: a store that nobody holds, whole or damaged; nothing that is no store.
/// A path that does not exist passes. Errors: kInvalidArgument, kBusy.
void require_replaceable_store(const std::filesystem::path& path, const BackendRegistry& backends);

}  // namespace plait
