// A file of records without a name: no process finds it, and it ends with its last descriptor,
// however the program ends.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The name that such a file has for a moment.
inline constexpr char kTemporaryName[] = "temporary";

inline File temporary_file(const Directory& in) {
  File file(in, kTemporaryName, OpenMode::kCreate);
  in.remove(kTemporaryName);
  return file;
}

/// Puts bytes behind each other into a file, by calls of a certain size.
class SequentialWriter {
 public:
  /// `file` outlives the object.
  SequentialWriter(File& file, std::uint64_t offset, std::size_t buffer_bytes)
      : file_(&file), offset_(offset) {
    buffer_.reserve(buffer_bytes);
  }

  void put(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const std::size_t fits = std::min(bytes.size(), buffer_.capacity() - buffer_.size());
      buffer_.insert(buffer_.end(), bytes.begin(),
                     bytes.begin() + static_cast<std::ptrdiff_t>(fits));
      bytes = bytes.subspan(fits);
      if (buffer_.size() == buffer_.capacity()) flush();
    }
  }
  void put(std::byte byte) {
    buffer_.push_back(byte);
    if (buffer_.size() == buffer_.capacity()) flush();
  }
  void flush() {
    if (buffer_.empty()) return;
    file_->write_at(offset_, buffer_);
    offset_ += buffer_.size();
    buffer_.clear();
  }

 private:
  File* file_;
  std::uint64_t offset_;
  std::vector<std::byte> buffer_;
};

/// Takes records of a part of a file, in their order.
template <class Record>
class SequentialReader {
 public:
  SequentialReader() = default;
  /// `file` outlives the object; the buffer has at least one record.
  SequentialReader(const File& file, std::uint64_t offset, std::uint64_t count,
                   std::size_t buffer_bytes)
      : file_(&file), offset_(offset), left_(count) {
    const std::size_t fits = std::max<std::size_t>(1, buffer_bytes / sizeof(Record));
    buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(fits, count)));
    at_ = buffer_.size();
  }

  /// Returns false at the end.
  bool next(Record& record) {
    if (left_ == 0) return false;
    if (at_ == buffer_.size()) fill();
    record = buffer_[at_++];
    --left_;
    return true;
  }

 private:
  void fill() {
    if (left_ < buffer_.size()) buffer_.resize(static_cast<std::size_t>(left_));
    file_->read_at(offset_, std::as_writable_bytes(std::span(buffer_)));
    offset_ += buffer_.size() * sizeof(Record);
    at_ = 0;
  }

  const File* file_ = nullptr;
  std::uint64_t offset_ = 0, left_ = 0;
  std::vector<Record> buffer_;
  std::size_t at_ = 0;
};

/// Records that are read in the order in which they were put.
template <class Record>
class RecordFile {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  explicit RecordFile(const Directory& in)
      : file_(temporary_file(in)), writer_(file_, 0, kBufferBytes) {}
  RecordFile(const RecordFile&) = delete;
  RecordFile& operator=(const RecordFile&) = delete;

  void put(const Record& record) {
    writer_.put(std::as_bytes(std::span(&record, 1)));
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  /// All records, from the first on. The object outlives the result.
  SequentialReader<Record> read() {
    writer_.flush();
    return {file_, 0, count_, kBufferBytes};
  }

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 20;

  File file_;
  SequentialWriter writer_;
  std::uint64_t count_ = 0;
};

PLAIT_END_NAMESPACE
