// plait/block_maker.h: makes blocks again from the base mesh, so that a store need not contain
// them.
//
// A level that a subdivision scheme has made is a function of the base mesh. If the pipeline of a
// level begins with the stage "predicted", a backend that compresses compares each block that it
// writes with what the scheme makes. A block that is equal is stored in no bytes: its entry in the
// block table has the encoding kPredicted and the checksum of the block's bytes. A read makes the
// block again and verifies the checksum.
//
// The stage has a recipe, which says what makes the level: "predicted:loop/position/float32/5".
// Store::plan_levels() writes it into the pipeline of an attribute. A level keeps the recipe that
// it was made with, and the base mesh of a store never changes, so nothing can invalidate a
// predicted block. The engine contains no maker: the library's are in its kernels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "plait/attribute.h"
#include "plait/level_geometry.h"
#include "plait/namespace.h"
#include "plait/provenance.h"
#include "plait/topology.h"
#include "plait/vector3.h"

PLAIT_BEGIN_NAMESPACE

/// The name of the stage. It is the first stage of a pipeline, before all filters.
inline constexpr std::string_view kPredictedStage = "predicted";

/// Whether the pipeline begins with the stage, with or without a recipe.
bool has_predicted_stage(std::string_view pipeline) noexcept;
/// The recipe of the pipeline's stage; empty if there is no stage or no recipe.
std::string_view recipe_in(std::string_view pipeline) noexcept;
/// The same pipeline with another recipe, or with none. A pipeline without the stage stays as it
/// is.
std::string with_recipe(std::string_view pipeline, std::string_view recipe);
/// The pipeline without the stage.
std::string without_predicted_stage(std::string_view pipeline);

/// Makes the blocks of one level of one attribute. Immutable; any number of threads may use it.
class BlockMaker {
 public:
  virtual ~BlockMaker() = default;
  /// The most memory that one call of make() or makes() uses. It depends on the geometry of the
  /// level and on the base mesh, and not on the block.
  virtual std::uint64_t scratch_bytes() const noexcept = 0;
  /// Fills `raw` with the records of the block, whose size it has.
  virtual void make(std::uint64_t block, std::span<std::byte> raw) const = 0;
  /// Whether make() would give exactly these bytes. Ends soon after the first difference.
  virtual bool makes(std::uint64_t block, std::span<const std::byte> raw) const = 0;
};

/// The level that a maker is for. The referenced objects outlive the maker.
struct MadeLevel {
  std::string_view recipe = {};  ///< only during the call
  AttributeSchema schema = {};
  const LevelGeometry& geometry;
  Topology mesh = {};
  std::span<const Vector3<double>> positions = {};  ///< of the base mesh, as imported
};

/// Knows recipes. Immutable; any number of threads may use it.
class BlockMakers {
 public:
  virtual ~BlockMakers() = default;
  /// The recipe of the levels up to `finest_level` of an attribute with this name and type, if the
  /// store's levels were made as `provenance` says. Empty if such levels cannot be made again. (The
  /// attribute's records may be others: blocks are compared.)
  virtual std::string recipe(const Provenance& provenance, const AttributeSchema& schema,
                             int finest_level) const = 0;
  /// nullptr if blocks of this level are never made: the records have another type, or the mesh is
  /// not suitable. Errors: kNotSupported for a scheme that is not known here; kInvalidArgument for
  /// text that is no recipe.
  virtual std::unique_ptr<BlockMaker> open(const MadeLevel& level) const = 0;
};

/// The makers of the library's own schemes. (The part of the library that has the schemes defines
/// this function.)
std::shared_ptr<const BlockMakers> library_block_makers();

PLAIT_END_NAMESPACE
