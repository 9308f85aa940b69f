// publish/served_store.h: the files of a store that a viewer reads, made from the open store: no
// file of the disk is named by a request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "plait/detail/namespace.h"
#include "plait/extend/session.h"
#include "plait/progress.h"
#include "plait/reader.h"
#include "plait/store.h"
#include "publish/make_view.h"

PLAIT_BEGIN_NAMESPACE

/// Threads: shared (docs/threads.md). Counts as a reader of the store.
class ServedStore {
 public:
  struct File {
    std::string content_type;
    std::uint64_t bytes = 0;
    std::string_view text = {};            ///< the whole file, if it is not one of records
    std::span<const std::byte> base = {};  ///< the whole file, if it is one of base records
    const LevelFile* level = nullptr;      ///< whose records the file has
  };

  /// Reads or makes the view. Errors: those of view_of().
  ServedStore(Store& store, const ProgressCallback& progress);
  ServedStore(const ServedStore&) = delete;
  ServedStore& operator=(const ServedStore&) = delete;

  /// The file that a viewer asks for as "/NAME"; nullptr if there is none.
  const File* find(const std::string& path) const;
  /// Reads bytes of a file from `offset` on, whatever backend the store has; blocks are decoded and
  /// compared with their checksums. REQUIRES: they are in the file. Errors: kCorruption, kIo,
  /// kBudget.
  void read(const File& file, std::uint64_t offset, std::span<std::byte> into) const;

  std::uint64_t view_bytes() const { return view_.size(); }
  /// Different for each version of each store: what a browser has kept of one is not used for
  /// another.
  const std::string& tag() const { return tag_; }

 private:
  std::vector<std::byte> view_;
  std::unordered_map<std::string, File> files_;
  std::string tag_;
  Reader reader_;  ///< keeps the store as it is, and its files open
  mutable Session session_;
};

PLAIT_END_NAMESPACE
