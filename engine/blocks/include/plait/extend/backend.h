// plait/extend/backend.h: the interface of a backend. A backend moves blocks between memory and the
// place where a level is stored, and does nothing else. The pager decides which blocks are
// resident, and counts them.
//
// A backend opens a Volume for a store. The volume opens a Backend for each level of each
// attribute. Threads: a Backend is called by part, for different blocks (docs/threads.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/block_table.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_NAMESPACE

class FaceDepths;

/// Blocks [first, first + count) of a level.
struct BlockRange {
  std::uint64_t first = 0, count = 0;
};

/// What the caller will do with blocks: no longer use their addresses, for now; read them in order;
/// or write all of them.
enum class Advice : std::uint8_t { kDontNeed, kSequential, kOverwrite };

/// The properties of a backend. The engine reads these flags only: it never decides by a backend's
/// name, and it never infers one flag from another.
struct BackendTraits {
  /// A level is a file, which exists after the process has ended.
  bool durable = false;
  /// A level is memory of this process. Every block has an address, and the memory there is the
  /// block's frame. No block is copied and none has a checksum.
  bool in_memory = false;
  /// If a level is opened for reading, address() returns mapped memory. Readers read the blocks
  /// there, without a copy.
  bool maps_for_reading = false;
  /// A write overwrites the old bytes of the block, at the offset that LevelGeometry gives. So the
  /// store must save the old bytes first, or write to a new file. A backend without this flag
  /// copies on write.
  bool overwrites_in_place = false;
  /// The stored size of a block differs from its raw size.
  bool compressed = false;
  /// start_run() moves adjacent blocks in one call of the operating system, so the pager hands runs
  /// over. For a backend without this flag the pager begins each transfer as soon as it can.
  bool moves_runs = false;
  /// What a level writes stays in the system's page cache, so reading it again costs a copy. A
  /// session that only writes then keeps few frames (SessionOptions::only_writes).
  bool in_page_cache = false;
  /// Levels of one attribute may be in one file (LevelSpec::shares_file).
  bool shares_files = false;
};

/// The block size of a store that asks for none. Random reads and small commits want small blocks,
/// and adjacent blocks of raw levels move together all the same. Compressed blocks move one by one
/// and lose about a hundredth of their ratio with each halving
/// (docs/benchmarks.md).
constexpr std::uint64_t default_block_bytes(const BackendTraits& traits) {
  return std::uint64_t{traits.compressed ? 256u : 64u} << 10;
}
/// The block size of a copy that asks for none: that of the source; but if that has the default of
/// its backend, the copy has that of its own.
constexpr std::uint64_t block_bytes_of_copy(const BackendTraits& source, std::uint64_t block_bytes,
                                            const BackendTraits& copy) {
  return block_bytes == default_block_bytes(source) ? default_block_bytes(copy) : block_bytes;
}

/// The most bytes of adjacent blocks that the pager hands over at once, and the most blocks. Larger
/// calls do not make a disk faster.
inline constexpr std::uint64_t kRunBytes = std::uint64_t{1} << 20;
inline constexpr std::size_t kMostRunBlocks = 256;

struct Transfer;

/// The largest number of blocks that are needed to encode or decode one block.
inline constexpr std::size_t kMostContextBlocks = 64;

/// A block whose bytes are needed to encode or decode another block. Examples are the coarser block
/// of the same edges, or a block of another attribute. Attribute and level are numbered as in
/// BlockTable.
struct ContextBlock {
  std::uint32_t attribute = 0;
  int level = 0;
  std::uint64_t block = 0;
};

/// A backend calls the listener when a transfer has ended, on any thread.
class TransferListener {
 public:
  /// Called once per transfer. `error` is nullptr if the transfer succeeded. The listener may use
  /// the transfer again at once.
  virtual void finished(Transfer& transfer, std::exception_ptr error) noexcept = 0;

 protected:
  ~TransferListener() = default;
};

/// One block on its way between memory and a backend. The caller owns the transfer and the memory.
/// Until the backend calls the listener, the caller must not free either of them, and must not
/// change the memory. During a read it must not read the memory either.
struct Transfer {
  enum class Direction : std::uint8_t { kRead, kWrite };
  Direction direction = Direction::kRead;
  std::uint64_t block = 0;
  std::span<std::byte> memory = {};  ///< the block's raw bytes; a write does not change them
  /// The bytes of the blocks that Backend::context() named, in that order. These blocks are pinned,
  /// and nobody changes them.
  std::span<const std::span<const std::byte>> context = {};
  TransferListener* listener = nullptr;
  std::uint32_t tag = 0;  ///< for use by the listener
};

/// One level of one attribute, as a backend stores it. Threads: by part, different blocks
/// (docs/threads.md).
class Backend {
 public:
  virtual ~Backend() = default;

  /// Reads whole blocks: fills `into` with their raw bytes, one block after another, or throws. A
  /// block that was never written reads as zeros. Verifies the checksum of every block, unless the
  /// level is in memory: levels in memory have no checksums. If `into` is the blocks' own address,
  /// the backend copies no bytes. Errors: kIo, kCorruption.
  virtual void read(BlockRange blocks, std::span<std::byte> into) = 0;

  /// Writes whole blocks from `from` and seals them in the block table. When the call returns, the
  /// operating system has all bytes. If `from` is the blocks' own address, the backend copies no
  /// bytes. Errors: kIo, kNoSpace; kBadState if the level was opened for reading.
  virtual void write(BlockRange blocks, std::span<const std::byte> from) = 0;

  /// Begins to read or write one block. The default calls read() or write(), and then the listener.
  /// A backend that keeps several blocks in flight returns before the transfer has ended.
  virtual void start(Transfer& transfer) noexcept;

  /// The same for at most kMostRunBlocks transfers of one direction, without context, each of the
  /// block after the one before. Each transfer ends by itself: the error of one block is not that
  /// of the others. The default starts one after another. The array is only valid during the call.
  virtual void start_run(std::span<Transfer* const> run) noexcept;

  /// The address of the block's bytes, valid while the backend exists. Returns nullptr, unless the
  /// level is in memory, or is mapped and was opened for reading. Callers may change the bytes only
  /// if the level is in memory. Changes take effect when write() is called with this address.
  /// Errors: kCorruption if the file is too short.
  virtual std::byte* address(std::uint64_t block) {
    static_cast<void>(block);
    return nullptr;
  }

  /// Fills `blocks` with the blocks that must be in memory to encode or decode `block`, and returns
  /// their number. Each of them comes earlier in the order of (attribute, level), so no two blocks
  /// need each other. The result must stay the same while the level is open. If the result is not
  /// empty, the pager passes these blocks with every transfer of `block` (Transfer::context), and
  /// read() and write() of `block` throw kNotSupported. When `block` is written, the levels of
  /// these blocks become fixed: the pager writes these blocks first, and refuses later changes of
  /// their levels (LevelFile::is_fixed). All blocks of a level need blocks of the same levels. The
  /// pager does not call context() for levels in memory.
  virtual std::size_t context(std::uint64_t block,
                              std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
    static_cast<void>(block), static_cast<void>(blocks);
    return 0;
  }

  /// The same for a read of the block as it is stored now: those blocks, of which context() names,
  /// that a read needs. A block that is made again needs others than one that is decoded
  /// (plait/extend/block_maker.h). The context of a read is either this one or that of context().
  /// The pager does not call it while the block is being written.
  virtual std::size_t read_context(
      std::uint64_t block, std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
    return context(block, blocks);
  }

  /// Whether a block that was written is encoded with the help of the base records of the attribute
  /// with this number. If so, the store refuses changes of these records. The store does not call
  /// it while a block of the level is being written.
  virtual bool needs_base_records(std::uint32_t attribute) const noexcept {
    static_cast<void>(attribute);
    return false;
  }

  /// A hint for the operating system. It changes no result and never fails.
  virtual void advise(BlockRange blocks, Advice advice) noexcept = 0;

  /// All blocks that were written so far become part of the version that is being committed. With
  /// `durable`, their bytes are on the disk when the call returns. A backend that does not
  /// overwrite in place must not reuse the space of version V's blocks before version V + 2 is
  /// committed, nor while a reader has version V open (Volume::begin_version). Errors: kIo,
  /// kNoSpace.
  virtual void sync(bool durable) = 0;

  /// Bytes that the level takes on the disk, or in memory if it is in memory.
  virtual std::uint64_t stored_bytes() const = 0;
};

/// The levels of one attribute, as far as they are open: what a filter may predict a block from.
struct AttributeLevels {
  std::uint32_t number = 0;  ///< as in BlockTable
  AttributeSchema schema = {};
  std::span<const std::byte> base = {};  ///< the records of the base vertices
  /// Coarser levels first: levels[i] is refined i + 1 times from the base mesh.
  std::vector<const LevelGeometry*> levels = {};
};

/// The mesh around a level, and the levels that were opened before it. The referenced objects
/// outlive the backend. Without a mesh, filters that need other blocks cannot transform a block.
struct LevelSurroundings {
  Topology mesh = {};
  int base_level = 0;
  std::vector<AttributeLevels> attributes = {};
  std::span<const Vector3<double>> positions = {};  ///< of the base mesh, as imported
  /// Of the faces (docs/adaptive.md); null if all faces have all levels.
  const FaceDepths* depths = nullptr;
};

/// The block table of a level in an older version that readers have open.
struct HeldTable {
  std::uint64_t version = 0;
  const BlockTable* table = nullptr;
};

/// The arguments with which a volume opens one level of one attribute. The referenced objects
/// outlive the backend.
struct LevelSpec {
  const Directory& directory;  ///< of the store; not open if the store is only in memory
  std::string name;            ///< of the level's file in the directory
  OpenMode mode = OpenMode::kCreate;
  const LevelGeometry& geometry;
  BlockTable& table;
  AttributeSchema schema = {};  ///< the type of the level's records
  Pipeline pipeline = {};       ///< how blocks are encoded
  /// The file has other levels too. A new level is added to the file, which the coarsest one makes.
  /// Only for backends with BackendTraits::shares_files.
  bool shares_file = false;
  /// Where the level begins in a shared file, if LevelGeometry gives the offsets of blocks. Offsets
  /// in the block table count from the begin of the file.
  std::uint64_t first_byte = 0;
  /// Tables of older versions with blocks in the same file. The backend must not overwrite these
  /// blocks. Only open_level() reads the tables.
  std::vector<HeldTable> held = {};
  LevelSurroundings surroundings = {};

  /// For messages.
  std::filesystem::path path() const { return directory.path_of(name); }
};

/// A level that will be opened.
struct FutureLevel {
  LevelGeometry geometry;
  AttributeSchema schema;
  Pipeline pipeline;
  std::uint32_t attribute = 0;  ///< its number
  int level = 0;
  const LevelSurroundings* surroundings = nullptr;  ///< as they are now
};

/// How a volume is opened.
struct VolumeSpec {
  /// The part of the store's budget that the volume may use, and the number of threads that call it
  /// at the same time.
  std::uint64_t most_scratch_bytes = ~std::uint64_t{0};
  int threads = 1;
};

/// One store as its backend opens it. It opens the levels and owns the resources that they share,
/// such as coders, io_uring queues and memory. It outlives its levels. Threads: one at a
/// time for open_level() and begin_version() (docs/threads.md).
class Volume {
 public:
  virtual ~Volume() = default;
  /// Errors: kIo, kNoSpace, kCorruption and kNotFound for the level's file; kInvalidArgument.
  virtual std::unique_ptr<Backend> open_level(const LevelSpec& level) = 0;
  /// The most memory that all levels together use in addition to frames, at most
  /// VolumeSpec::most_scratch_bytes. It grows with the block size of the opened levels.
  virtual std::uint64_t scratch_bytes() const noexcept { return 0; }
  /// The most that scratch_bytes() is while these levels, too, are opened one after another. So
  /// work that its budget cannot hold is refused before it begins.
  virtual std::uint64_t scratch_bytes_with(std::span<const FutureLevel> levels) const {
    static_cast<void>(levels);
    return scratch_bytes();
  }
  /// The store calls this after version `sequence` is committed; all blocks written so far are part
  /// of that version. `held` are the older versions that readers have open, in ascending order. The
  /// backend must not overwrite blocks of these versions.
  virtual void begin_version(std::uint64_t sequence, std::span<const std::uint64_t> held) {
    static_cast<void>(sequence);
    static_cast<void>(held);
  }
};

using OpenLevel = std::function<std::unique_ptr<Backend>(const LevelSpec&)>;
using OpenVolume = std::function<std::unique_ptr<Volume>(const VolumeSpec&)>;

/// A volume for backends whose levels share no resources.
OpenVolume open_each_level(OpenLevel open);

PLAIT_END_NAMESPACE
