// plait/backend.h: what moves blocks between memory and wherever a level is kept; nothing else.
// Residency, dirtiness, eviction and statistics belong to the pager.
//
// One Backend serves one level of one attribute. Calls for different blocks may come from several
// threads at once; calls for the same block never do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/block_table.h"
#include "plait/file.h"
#include "plait/level_geometry.h"

namespace plait {

/// Blocks [first, first + count) of a level.
struct BlockRange {
  std::uint64_t first = 0, count = 0;
};

enum class Advice : std::uint8_t { kWillNeed, kDontNeed, kSequential, kRandom };

/// Capabilities as data: nobody asks for a backend's name to know what it can do.
struct BackendTraits {
  bool direct = false;      ///< hands out addresses; the pager then copies nothing
  bool compressed = false;  ///< stored size differs from raw size
  bool durable = false;     ///< keeps data after the process: the level is a file
};

class Backend {
 public:
  virtual ~Backend() = default;

  virtual BackendTraits traits() const noexcept = 0;

  /// Whole blocks into `into` (their raw bytes one after another), or a throw. A block that was
  /// never written reads as zeros. Every block's checksum is verified.
  /// Errors: kIo, kCorruption.
  virtual void read(BlockRange blocks, std::span<std::byte> into) = 0;

  /// Whole blocks from `from`, sealed in the block table. All is handed over when it returns.
  /// Errors: kIo, kNoSpace.
  virtual void write(BlockRange blocks, std::span<const std::byte> from) = 0;

  /// Direct backends: the block's bytes, at one address while the backend lives. The pager checks
  /// and seals the block. Others: nullptr.
  virtual std::byte* address(std::uint64_t block) = 0;

  /// Never changes a result, never fails.
  virtual void advise(BlockRange blocks, Advice advice) noexcept = 0;

  /// Hands all bytes of these blocks to the operating system without waiting for the disk.
  virtual void flush(BlockRange blocks) = 0;
  /// Makes all that was written durable. Errors: kIo, kNoSpace.
  virtual void sync() = 0;

  /// Bytes that the level takes where it is kept.
  virtual std::uint64_t stored_bytes() const = 0;
};

/// How a backend is to be opened, from the command line or a manifest.
struct BackendOptions {
  std::string codec = "zstd:1";  ///< "none", "lz4", "zstd", "zstd:LEVEL"; compressed backends only
  std::string filter = "shuffle";  ///< "none", "shuffle"
};

/// One level of one attribute as a backend sees it. The references outlive the backend.
struct LevelSpec {
  std::filesystem::path path;  ///< the level's file; empty in a store that is only in memory
  OpenMode mode = OpenMode::kCreate;
  const LevelGeometry& geometry;
  BlockTable& table;
  const BackendOptions& options;
  std::size_t component_bytes = 4;  ///< what a shuffle filter groups by
};

/// Names to backends. The engine knows none by itself; plait::default_backends() has the built-in
/// ones, and a program may add its own.
class BackendRegistry {
 public:
  struct Entry {
    std::string name;
    std::string summary;  ///< one line for --help
    BackendTraits traits;
    std::function<std::unique_ptr<Backend>(const LevelSpec&)> open;
    /// Checks options before anything is made; throws kInvalidArgument or kNotSupported.
    std::function<void(const BackendOptions&)> validate;
  };

  /// Errors: kInvalidArgument if the name is taken.
  void add(Entry entry);
  /// Errors: kNotSupported naming the backends there are.
  const Entry& find(std::string_view name) const;
  std::vector<std::string> names() const;

 private:
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace plait
