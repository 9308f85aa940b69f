// plait/backend.h: what moves blocks between memory and wherever a level is kept; nothing else.
// Residency, dirtiness, eviction and statistics belong to the pager.
//
// One Backend serves one level of one attribute. Calls for different blocks may come from several
// threads at once; calls for the same block never do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/block_table.h"
#include "plait/directory.h"
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

struct Transfer;

/// Is told when a transfer has ended, from whatever thread that happens in.
class TransferListener {
 public:
  /// Once per transfer, with its error or nullptr. The transfer may be used anew at once.
  virtual void finished(Transfer& transfer, std::exception_ptr error) noexcept = 0;

 protected:
  ~TransferListener() = default;
};

/// One block on its way between memory and a backend. Transfer and memory are the caller's, who
/// keeps both, and leaves the memory alone, until the listener was told.
struct Transfer {
  enum class Direction : std::uint8_t { kRead, kWrite };
  Direction direction = Direction::kRead;
  std::uint64_t block = 0;
  std::span<std::byte> memory;  ///< the block's raw bytes; a write does not change them
  TransferListener* listener = nullptr;
  std::uint32_t tag = 0;  ///< the listener's
};

class Backend {
 public:
  virtual ~Backend() = default;

  virtual BackendTraits traits() const noexcept = 0;

  /// Whole blocks into `into` (their raw bytes one after another), or a throw. A block that was
  /// never written reads as zeros. Every block's checksum is verified, unless the backend is
  /// neither durable nor compressed: what never leaves memory is not hashed. Direct backends: if
  /// `into` is the blocks' own address, nothing is copied. Errors: kIo, kCorruption.
  virtual void read(BlockRange blocks, std::span<std::byte> into) = 0;

  /// Whole blocks from `from`, sealed in the block table. All is handed to the operating system
  /// when it returns. Direct backends: as read(). Errors: kIo, kNoSpace.
  virtual void write(BlockRange blocks, std::span<const std::byte> from) = 0;

  /// Begins to read or write one block. As it stands it does all of it with read() or write(); a
  /// backend that keeps several blocks in flight returns before the transfer has ended.
  virtual void start(Transfer& transfer) noexcept;

  /// Direct backends: the block's bytes, at one address while the backend lives. Nothing may be
  /// stored there before it was asked for as `writable`; what is, counts once write() was called
  /// with this address. Others: nullptr. Errors: kCorruption for a file that was cut short; kIo,
  /// kNoSpace if what must be kept of the block cannot be.
  virtual std::byte* address(std::uint64_t block, bool writable) = 0;

  /// Never changes a result, never fails.
  virtual void advise(BlockRange blocks, Advice advice) noexcept = 0;

  /// What was written so far becomes part of the version that is being committed: until the next
  /// call but one no later write touches it, unless the backend writes in place. With `durable` it
  /// is on the disk when this returns. Errors: kIo, kNoSpace.
  virtual void sync(bool durable) = 0;

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
  const Directory& directory;  ///< the store's; not open for a store that is only in memory
  std::string name;            ///< of the level's file in the directory
  OpenMode mode = OpenMode::kCreate;
  const LevelGeometry& geometry;
  BlockTable& table;
  const BackendOptions& options;
  std::size_t component_bytes = 4;  ///< what a shuffle filter groups by

  /// For messages.
  std::filesystem::path path() const { return directory.path_of(name); }
};

/// Names to backends. The engine knows none by itself; plait::default_backends() has the built-in
/// ones, and a program may add its own.
class BackendRegistry {
 public:
  struct Entry {
    std::string name = {};
    std::string summary = {};  ///< one line for --help
    BackendTraits traits = {};
    std::function<std::unique_ptr<Backend>(const LevelSpec&)> open = {};
    /// Checks options before anything is made; throws kInvalidArgument or kNotSupported.
    std::function<void(const BackendOptions&)> validate = {};
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
