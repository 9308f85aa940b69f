// plait/backend.h: what moves blocks between memory and wherever a level is kept; nothing else.
// Residency, dirtiness, eviction and statistics belong to the pager.
//
// A backend opens a Volume for a store, and the volume a Backend for each level of each attribute.
// Calls of a Backend for different blocks may come from several threads at once; calls for the same
// block never do.
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

/// What a backend is, said outright: nobody asks for its name, or infers one answer from another.
struct BackendTraits {
  /// A level is a file, and is there after the process.
  bool durable = false;
  /// A level is memory of this process. Every block has an address, which is its frame, and is
  /// stored into there; nothing is moved and nothing is hashed.
  bool in_memory = false;
  /// A level that was opened for reading hands out addresses, where its blocks are read without
  /// being copied.
  bool maps_for_reading = false;
  /// A write goes to where the geometry has the block, over what the block held before: what a
  /// crash must be able to bring back is kept in the journal. Others copy on write.
  bool overwrites_in_place = false;
  /// The stored size of a block differs from its raw size.
  bool compressed = false;
};

struct Transfer;

/// At most so many blocks are needed to code one block.
inline constexpr std::size_t kMostContextBlocks = 4;

/// A block whose bytes are needed to encode or decode another one: the coarser block of the same
/// edges, say, or another attribute's block. Attribute and level are numbered as in BlockTable.
struct ContextBlock {
  std::uint32_t attribute = 0;
  int level = 0;
  std::uint64_t block = 0;
};

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
  std::span<std::byte> memory = {};  ///< the block's raw bytes; a write does not change them
  /// The bytes of the blocks that Backend::context() named, in that order. They are pinned, and
  /// nobody stores into them.
  std::span<const std::span<const std::byte>> context = {};
  TransferListener* listener = nullptr;
  std::uint32_t tag = 0;  ///< the listener's
};

class Backend {
 public:
  virtual ~Backend() = default;

  /// Whole blocks into `into` (their raw bytes one after another), or a throw. A block that was
  /// never written reads as zeros. Every block's checksum is verified, unless the level is in
  /// memory: what never leaves memory is not hashed. If `into` is the blocks' own address, nothing
  /// is copied. Errors: kIo, kCorruption.
  virtual void read(BlockRange blocks, std::span<std::byte> into) = 0;

  /// Whole blocks from `from`, sealed in the block table. All is handed to the operating system
  /// when it returns. If `from` is the blocks' own address, nothing is copied.
  /// Errors: kIo, kNoSpace; kBadState if the level was opened for reading.
  virtual void write(BlockRange blocks, std::span<const std::byte> from) = 0;

  /// Begins to read or write one block. As it stands it does all of it with read() or write(); a
  /// backend that keeps several blocks in flight returns before the transfer has ended.
  virtual void start(Transfer& transfer) noexcept;

  /// Where the block's bytes are, for as long as the backend lives; nullptr unless the level is in
  /// memory, or is mapped and was opened for reading. Only into a level in memory anything may be
  /// stored there; it counts once write() was called with this address.
  /// Errors: kCorruption for a file that was cut short.
  virtual std::byte* address(std::uint64_t block) {
    static_cast<void>(block);
    return nullptr;
  }

  /// Which blocks must be in memory to encode or decode this block; returns how many there are.
  /// Each comes earlier in the order of (level, attribute), so that no two blocks need each other.
  /// The answer is the same for as long as the level is open. A backend that names some is given
  /// them with every transfer, and does without read() and write(), which throw kNotSupported.
  /// Levels in memory are never asked.
  virtual std::size_t context(std::uint64_t block,
                              std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
    static_cast<void>(block), static_cast<void>(blocks);
    return 0;
  }

  /// Never changes a result, never fails.
  virtual void advise(BlockRange blocks, Advice advice) noexcept = 0;

  /// What was written so far becomes part of the version that is being committed. With `durable` it
  /// is on the disk when this returns. A backend that does not overwrite in place leaves the blocks
  /// of a version alone until the next version but one was committed, and as long as readers have
  /// the version open (Volume::begin_version). Errors: kIo, kNoSpace.
  virtual void sync(bool durable) = 0;

  /// Bytes that the level takes where it is kept.
  virtual std::uint64_t stored_bytes() const = 0;
};

/// The block table that an older version has for a level, while readers have that version open.
struct HeldTable {
  std::uint64_t version = 0;
  const BlockTable* table = nullptr;
};

/// One level of one attribute as a backend sees it. The references outlive the backend.
struct LevelSpec {
  const Directory& directory;  ///< the store's; not open for a store that is only in memory
  std::string name;            ///< of the level's file in the directory
  OpenMode mode = OpenMode::kCreate;
  const LevelGeometry& geometry;
  BlockTable& table;
  std::size_t component_bytes = 4;  ///< what a shuffle filter groups by
  /// How blocks are encoded: stages such as "shuffle,zstd:1", or "none".
  std::string pipeline = "none";
  /// Tables of older versions whose blocks, in the same file, must stay as they are. Read by
  /// open_level() only.
  std::vector<HeldTable> held = {};

  /// For messages.
  std::filesystem::path path() const { return directory.path_of(name); }
};

/// How a volume is opened.
struct VolumeSpec {
  std::string options = {};  ///< "key=value,...": what the store's backend has behind its name
  /// What the volume may take of the store's budget, and how many threads will call at once.
  std::uint64_t most_scratch_bytes = ~std::uint64_t{0};
  int threads = 1;
};

/// All levels of one store as a backend keeps them, and what these have together: coders, rings,
/// memory. It outlives its levels. open_level() and begin_version() are called by one thread at a
/// time.
class Volume {
 public:
  virtual ~Volume() = default;
  /// Errors: kIo, kNoSpace, kCorruption, kNotFound as the level's file has it; kInvalidArgument.
  virtual std::unique_ptr<Backend> open_level(const LevelSpec& level) = 0;
  /// The most memory that all levels together take beside frames: at most what the specification
  /// allows. Grows with the blocks of the levels that are opened.
  virtual std::uint64_t scratch_bytes() const noexcept { return 0; }
  /// Version `sequence` was committed: all that was written so far is part of it. Readers have the
  /// older versions `held` open, in ascending order: blocks of these must stay as they are.
  virtual void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
    static_cast<void>(sequence);
    static_cast<void>(held);
  }
};

using OpenLevel = std::function<std::unique_ptr<Backend>(const LevelSpec&)>;
using OpenVolume = std::function<std::unique_ptr<Volume>(const VolumeSpec&)>;

/// For backends whose levels have nothing together.
OpenVolume open_each_level(OpenLevel open);

/// Names to backends. The engine knows none by itself; plait::default_backends() has the built-in
/// ones, and a program may add its own.
class BackendRegistry {
 public:
  struct Entry {
    std::string name = {};
    std::string summary = {};  ///< one line for --help
    BackendTraits traits = {};
    OpenVolume open = {};
    /// Whether the backend can be had here with these options ("key=value,..."), asked before
    /// anything is made. Throws kInvalidArgument or kNotSupported. Empty: there are no options.
    std::function<void(std::string_view options)> validate = {};
    /// What encodes the blocks of a store that names no pipeline.
    std::string default_pipeline = "none";
    /// Refuses a pipeline that the backend cannot follow, with kInvalidArgument or kNotSupported.
    /// Empty: there is none but "none".
    std::function<void(std::string_view pipeline)> validate_pipeline = {};
  };

  /// Errors: kInvalidArgument if the name is taken or empty, or `open` is.
  void add(Entry entry);
  /// The backend that a specification ("name" or "name:key=value,...") names.
  /// Errors: kNotSupported naming the backends there are.
  const Entry& find(std::string_view specification) const;
  /// What a specification has behind the name: "key=value,...", or nothing.
  static std::string_view options_in(std::string_view specification);
  std::vector<std::string> names() const;

 private:
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace plait
