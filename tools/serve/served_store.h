// serve/served_store.h: the files of a store that a viewer reads, made from the open store: no file
// of the disk is named by a request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "plait/extend/session.h"
#include "plait/progress.h"
#include "plait/store.h"
#include "publish/make_view.h"

namespace plait {

/// Threads: shared (docs/threads.md). The store must outlive this object.
class ServedStore {
 public:
  struct File {
    std::string content_type;
    std::uint64_t bytes = 0;
    std::string_view text = {};  ///< the whole file, if it is not one of records
    const ViewedFile* records = nullptr;
  };

  /// Reads or makes the view. Errors: those of view_of().
  ServedStore(Store& store, const ProgressCallback& progress);

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
  const Store& store_;
  std::vector<std::byte> view_;
  std::vector<ViewedFile> records_;
  std::unordered_map<std::string, File> files_;
  std::string tag_;
  mutable Session session_;
};

}  // namespace plait
