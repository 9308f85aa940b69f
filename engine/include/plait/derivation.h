// plait/derivation.h: attributes that are computed when they are read.
//
// An attribute with the pipeline "derived:RULE/SOURCE" has no files. The rule computes its blocks
// from another attribute, the source: "derived:normals/position" has the normals of the stored
// positions. The pager reads blocks of the source, computes the derived block in a frame, and keeps
// the frame like any other one. If a program changes the source, the next pin of a derived block
// computes the block anew. See docs/derived.md.
//
// The engine contains no rule: the library's are in its kernels, and a BackendRegistry passes them
// to stores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/level_file.h"
#include "plait/level_geometry.h"
#include "plait/namespace.h"
#include "plait/pager.h"
#include "plait/topology.h"

PLAIT_BEGIN_NAMESPACE

/// The pipeline of a derived attribute, alone or before ":RULE/SOURCE".
inline constexpr std::string_view kDerived = "derived";

/// Whether attributes with this pipeline are derived.
bool is_derived(std::string_view pipeline) noexcept;
/// "normals/position" in "derived:normals/position"; empty if the pipeline says nothing else.
std::string_view derivation_in(std::string_view pipeline) noexcept;
std::string derived_pipeline(std::string_view derivation);

/// The blocks of a derived level have the same edges as those of the source's finest level, because
/// records of every level depend on that level. So a block is computed from few blocks of the
/// source. `refinements` and `finest` count from the base mesh.
LevelGeometry derived_geometry(const SlotShapes& shapes, int refinements, int finest,
                               std::size_t record_bytes, std::uint64_t block_bytes);

/// What a derived attribute is computed from. The referenced objects outlive the Deriver.
struct DerivationSource {
  Topology mesh = {};
  AttributeSchema schema = {};
  std::span<const std::byte> base = {};       ///< the records of the base vertices
  std::vector<const LevelFile*> levels = {};  ///< [refinements of the base mesh - 1]
  Pager* pager = nullptr;                     ///< has the levels
};

/// Computes the records of one derived attribute. Any number of threads may use it. It pins blocks
/// of the source, and holds no pin between two calls.
class Deriver {
 public:
  virtual ~Deriver() = default;
  /// The most memory that one call uses beside frames. make_base() also uses two records of the
  /// source for each base edge.
  virtual std::uint64_t scratch_bytes() const noexcept = 0;
  /// Fills `records` with the records of all base vertices. Reads the source's finest level once.
  /// Errors: those of Session::pin.
  virtual void make_base(std::span<std::byte> records) const = 0;
  /// Fills `raw` with the records of a block. `level` has the geometry that derived_geometry()
  /// gives. Errors: those of Session::pin.
  virtual void make(const LevelGeometry& level, std::uint64_t block,
                    std::span<std::byte> raw) const = 0;
};

/// Knows rules. Immutable; any number of threads may use it.
class Derivations {
 public:
  virtual ~Derivations() = default;
  /// The derivation of an attribute for which the user names none. Errors: kNotSupported if there
  /// is no rule for such records.
  virtual std::string usual(const AttributeSchema& schema) const = 0;
  /// The name of the source. Errors: kNotSupported for a rule that is not known, for text that is
  /// no derivation, and for records that the rule does not make.
  virtual std::string source_of(std::string_view derivation,
                                const AttributeSchema& schema) const = 0;
  /// Errors: as source_of(); also kNotSupported for records of the source that the rule cannot use.
  virtual std::unique_ptr<Deriver> open(std::string_view derivation, const AttributeSchema& schema,
                                        DerivationSource source) const = 0;
};

/// The library's own rules: normals/SOURCE. (The part of the library that has the rules defines
/// this function.)
std::shared_ptr<const Derivations> library_derivations();

PLAIT_END_NAMESPACE
