// The file changes.G: blocks that small commits changed, of all levels and attributes, and the
// records that name them (format/change_record.h). Bytes that a commit has made part of a version
// never change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Threads: read(), append() and write() are shared, for different blocks.
class ChangeLog {
 public:
  /// Opens the log of which the newest version needs the first `bytes` bytes; with kCreate, makes
  /// it, in the place of what a killed run left. Errors: kNotFound; kCorruption, also if the file
  /// is shorter; kIo, kNoSpace.
  ChangeLog(const Directory& store, std::uint64_t generation, OpenMode mode, std::uint64_t bytes);
  ~ChangeLog();

  std::uint64_t generation() const { return generation_; }
  const std::filesystem::path& path() const { return file_.path(); }
  /// The bytes that the newest version needs; 0 for a log that no version names yet.
  std::uint64_t committed() const { return committed_; }
  std::uint64_t end() const;
  /// Whether bytes were appended or changed since the last commit.
  bool has_changed() const { return end() != committed_; }

  /// Appends bytes, and takes disk space ahead, up to `most` bytes in all. Returns their offset.
  /// Errors: kIo, kNoSpace.
  std::uint64_t append(std::span<const std::byte> bytes, std::uint64_t most);
  /// REQUIRES: no version names these bytes.
  void write(std::uint64_t offset, std::span<const std::byte> bytes) {
    file_.write_at(offset, bytes);
  }
  /// Into its own address, if the log is mapped: then copies nothing. Errors: kIo, kCorruption.
  void read(std::uint64_t offset, std::span<std::byte> into);
  void sync() { file_.sync(); }

  /// Maps the file, for readers. Errors: kIo.
  void map();
  /// The address of bytes in the mapping. Errors: kCorruption if the file was cut short.
  std::byte* address(std::uint64_t offset) const;

  /// All that was appended belongs to the newest version.
  void commit() { committed_ = end(); }
  /// Nothing that was appended since the last commit counts.
  void roll_back();

 private:
  class Mapping;

  std::uint64_t generation_;
  File file_;
  std::unique_ptr<Mapping> mapping_;
  mutable std::mutex mutex_;  ///< of the fields below
  std::uint64_t committed_, end_, allocated_;
};

PLAIT_END_NAMESPACE
