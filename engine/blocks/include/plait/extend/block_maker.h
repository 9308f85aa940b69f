// plait/extend/block_maker.h: makes blocks again, so that a store need not contain them.
//
// A level that a subdivision scheme has made is a function of the base mesh, and normals are a
// function of positions. If the pipeline of a level begins with the stage "predicted", a backend
// that compresses compares each block that it writes with what the level's recipe makes. A block
// that is equal is stored in no bytes: its entry in the block table has the encoding kPredicted and
// the checksum of the block's bytes. A read makes the block again and verifies the checksum.
//
// A recipe is the text after the name of the stage (Pipeline::recipe). There are two kinds:
//   predicted:SCHEME/OUTPUT/PRECISION/LEVELS   from the base mesh: "loop/position/float32/5"
//   predicted:RULE/SOURCE/LEVELS               from another attribute: "normals/position/5"
// LEVELS is how often the base mesh was refined in all. StoreAccess::plan_levels() writes the
// recipe into the pipeline of an attribute: "predicted" and "predicted:normals/..." get one of
// either kind, all others, such as "predicted:base", one of the first kind. A level keeps the
// recipe that it was made with. The base mesh of a store never changes, and levels from which a
// block was made are fixed (LevelFile::is_fixed), so nothing invalidates a predicted block. The
// blocks of the source are context of the transfer (Backend::context). The engine contains no
// maker: the library's are in its kernels. See docs/made-blocks.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/provenance.h"

PLAIT_BEGIN_NAMESPACE

/// Levels of an attribute that will be added.
struct PlannedLevels {
  AttributeSchema schema = {};  ///< with the name that the attribute has in the end
  Provenance provenance = {};   ///< of the store
  int finest_level = 0;
  /// The levels of earlier attributes are complete, so that blocks can be made from them.
  bool others_are_complete = false;
};

/// What a recipe RULE/SOURCE/LEVELS says; nothing for other recipes.
struct RecipeSource {
  std::string_view rule, attribute;
  int levels = 0;
};
std::optional<RecipeSource> source_in(std::string_view recipe) noexcept;

/// The size of the blocks of a level with this pipeline that is refined `refinements` times from
/// the base mesh. Records of every level of RULE/SOURCE/LEVELS depend on the finest level of the
/// source. So blocks of coarser levels are smaller, and each of them is made from few blocks.
std::uint64_t block_bytes_of_level(const Pipeline& pipeline, int refinements,
                                   std::uint64_t block_bytes);

/// The most blocks of other levels from which one block is made.
inline constexpr std::size_t kMostSourceBlocks = 48;
/// Their bytes, in the order in which BlockMaker::sources() names them.
using SourceBytes = std::span<const std::span<const std::byte>>;

/// Makes the blocks of one level of one attribute. Immutable; any number of threads may use it.
class BlockMaker {
 public:
  virtual ~BlockMaker() = default;
  /// The most memory that one call of make() or makes() uses. It depends on the geometry of the
  /// level and on the base mesh, and not on the block.
  virtual std::uint64_t scratch_bytes() const noexcept = 0;
  /// Fills `blocks` with the blocks of earlier attributes from which `block` is made, and returns
  /// their number: 0 if it is made from the base mesh alone. The result stays the same.
  virtual std::size_t sources(std::uint64_t block,
                              std::span<ContextBlock, kMostContextBlocks> blocks) const noexcept {
    static_cast<void>(block), static_cast<void>(blocks);
    return 0;
  }
  /// The number of the attribute to which these blocks belong, and whose base records (as in
  /// AttributeLevels) are a source too; kNoId if blocks are made from the base mesh alone.
  virtual std::uint32_t source_attribute() const noexcept { return kNoId; }
  /// Fills `raw` with the records of the block, whose size it has. Errors: kNotSupported unless
  /// `sources` are those of the block.
  virtual void make(std::uint64_t block, SourceBytes sources, std::span<std::byte> raw) const = 0;
  /// Fills `records` with the records of the base vertices, of whatever level the maker is. Returns
  /// false if it makes none.
  virtual bool make_base(std::span<std::byte> records) const {
    static_cast<void>(records);
    return false;
  }
  /// Whether make() would give exactly these bytes. Ends soon after the first difference. False if
  /// `sources` are not those of the block.
  virtual bool makes(std::uint64_t block, SourceBytes sources,
                     std::span<const std::byte> raw) const = 0;
};

/// The level that a maker is for. The referenced objects outlive the maker; the recipe and
/// `surroundings` itself end with the call.
struct MadeLevel {
  std::string_view recipe = {};
  AttributeSchema schema = {};
  std::uint32_t attribute = 0;  ///< the attribute's number, as in BlockTable
  const LevelGeometry& geometry;
  const LevelSurroundings& surroundings;
};

/// Knows recipes. Immutable; any number of threads may use it.
class BlockMakers {
 public:
  virtual ~BlockMakers() = default;
  /// The recipe of these levels. Empty if such levels cannot be made again. (The attribute's
  /// records may be others: blocks are compared.)
  virtual std::string recipe(const PlannedLevels& levels) const = 0;
  /// nullptr if blocks of this level are never made: the records have another type, or the mesh or
  /// the source is not suitable. Errors: kNotSupported for a scheme or rule that is not known here;
  /// kInvalidArgument for text that is no recipe.
  virtual std::unique_ptr<BlockMaker> open(const MadeLevel& level) const = 0;
};

/// The makers of the library's own schemes and rules. (The part of the library that has them
/// defines this function.)
std::shared_ptr<const BlockMakers> library_block_makers();

PLAIT_END_NAMESPACE
