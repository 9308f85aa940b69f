// The records of all base vertices of one attribute: in memory, or in a file for as long as nobody
// asks for all of them. A store whose base mesh works take in pieces (BaseMesh::in_pieces()) has
// them in the file that the next version gets.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "base/zeroed_array.h"
#include "plait/extend/file.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Threads: as an array, where the first use as a span may read the file. Errors of that: kIo,
/// kOutOfMemory.
class BaseRecords {
 public:
  BaseRecords() = default;
  BaseRecords(ZeroedArray<std::byte> records) : records_(std::move(records)) {}
  /// Zeros, in an empty file that can be read and written. Errors: kIo, kNoSpace.
  BaseRecords(File file, std::uint64_t bytes);
  BaseRecords(const BaseRecords& other) : records_(other.whole()) {}
  BaseRecords& operator=(const BaseRecords& other) { return *this = BaseRecords(other); }
  BaseRecords(BaseRecords&&) noexcept = default;
  BaseRecords& operator=(BaseRecords&&) noexcept = default;
  ~BaseRecords() = default;

  std::uint64_t size() const { return file_ ? file_->bytes : records_.size(); }
  operator std::span<std::byte>() { return whole(); }
  operator std::span<const std::byte>() const { return whole(); }

  /// The file while it has the records, else nullptr.
  File* file() const { return file_ && !file_->is_loaded ? &file_->file : nullptr; }

  // These take memory for a part of the records alone.

  /// `records`: one after another, of vertices that ascend. Errors: kIo, kNoSpace.
  void put(std::span<const VertexId> vertices, std::span<const std::byte> records);
  /// The bytes from `first` on. Errors: kIo.
  void read(std::uint64_t first, std::span<std::byte> into) const;
  /// As checksums_of_pieces(). Errors: kIo.
  std::vector<std::uint64_t> piece_checksums() const;

 private:
  struct InFile {
    InFile(File records, std::uint64_t size) : file(std::move(records)), bytes(size) {}

    File file;
    std::uint64_t bytes;
    std::atomic<bool> is_loaded = false;
    std::mutex mutex;  ///< for loading
  };

  ZeroedArray<std::byte>& whole() const;

  mutable ZeroedArray<std::byte> records_;
  std::unique_ptr<InFile> file_;
};

PLAIT_END_NAMESPACE
