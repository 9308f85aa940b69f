// The description of a version of a store: all of the file version.S except the header and the
// block tables. Byte table: docs/format.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plait/attribute.h"
#include "plait/extend/block_table.h"
#include "plait/extend/pipeline.h"
#include "plait/extend/provenance.h"
#include "plait/extend/rounding.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// How a level represents its values. Stored: never renumber.
enum class Representation : std::uint32_t {
  kValues = 0,  ///< the values themselves
};

struct LevelRecord {
  Pipeline pipeline = {};
  Representation representation = Representation::kValues;
  std::uint64_t generation = 0;  ///< the version that made the level's file

  friend bool operator==(const LevelRecord&, const LevelRecord&) = default;
};

struct AttributeRecord {
  AttributeSchema schema;
  std::uint32_t number = 0;  ///< in file names and checksums; each number is used only once
  std::uint64_t base_bytes = 0, base_checksum = 0;  ///< of the file with the base records
  LevelPipelines pipeline = {};                     ///< of levels that are added later
  std::vector<LevelRecord> levels;                  ///< [level - base level - 1]
  std::optional<Rounding> rounding = {};  ///< of the records of all levels; nothing if exact
};

/// An attribute of the base faces: one integer for each face.
struct FaceAttributeRecord {
  AttributeSchema schema;
  std::uint32_t number = 0;  ///< from the same counter as AttributeRecord::number
  std::uint64_t checksum = 0;
};

/// One shard of all levels (plait/detail/edge_shards.h).
struct ShardRecord {
  std::uint32_t first_edge = 0;
  std::uint64_t tables_checksum = 0;  ///< of the file with its block tables

  friend bool operator==(const ShardRecord&, const ShardRecord&) = default;
};

/// Depths of the faces (format/depths_file.h).
struct DepthsRecord {
  std::uint64_t checksum = 0;        ///< of the file
  std::vector<std::uint32_t> slots;  ///< [level - base level - 1] slots that are not absent

  friend bool operator==(const DepthsRecord&, const DepthsRecord&) = default;
};

struct VersionDescription {
  std::uint64_t vertex_count = 0, edge_count = 0, face_count = 0, border_edge_count = 0;
  std::uint64_t block_bytes = 0;
  std::uint32_t next_attribute_number = 0;
  std::uint64_t base_mesh_bytes = 0, base_mesh_checksum = 0;
  std::string backend;           ///< as in StoreOptions
  LevelPipelines pipeline = {};  ///< of attributes that are added later
  Provenance provenance;         ///< includes layout and base level
  std::vector<AttributeRecord> attributes;
  Texts texts;
  std::vector<FaceAttributeRecord> face_attributes;
  std::vector<ShardRecord> shards;          ///< empty if each level is in one piece
  bool shares_files = false;                ///< a shard has one file for all levels of an attribute
  std::optional<DepthsRecord> depths = {};  ///< nothing if all faces have all levels

  int finest_level(const AttributeRecord& attribute) const {
    return provenance.base_level + static_cast<int>(attribute.levels.size());
  }
};

/// Limits that no real store reaches. They keep the memory small that a malicious file can make the
/// reader allocate.
constexpr std::size_t kMaxAttributes = 65535;
constexpr std::size_t kMaxFaceAttributes = 255;
constexpr std::size_t kMaxAttributeNameBytes = 255;
constexpr std::size_t kMaxTextBytes = 65536;
constexpr std::size_t kMaxDescriptionBytes = std::size_t{64} << 20;

/// Whether `name` is 1 to kMaxAttributeNameBytes characters of [A-Za-z0-9_-].
bool is_attribute_name(std::string_view name);

/// Errors: kInvalidArgument for text that is too long or not printable ASCII (Texts may be UTF-8),
/// for a name that is not an attribute name, and for too many attributes.
std::vector<std::byte> encode_description(const VersionDescription& version);

/// Checks that each field is in its range. Before it allocates memory for a count, it compares the
/// count with the bytes that are left. Ignores bytes after the last field: they belong to optional
/// features that `optional_features` (of the manifest) does not name. `sequence` is the number of
/// the version; `required_features` are those of the manifest. Errors: kCorruption (the message
/// names the field); kNotSupported for an unknown representation, and for text that is no pipeline.
/// The messages begin with `path`.
VersionDescription decode_description(std::span<const std::byte> bytes, std::uint64_t sequence,
                                      const std::filesystem::path& path,
                                      std::uint32_t optional_features = 0,
                                      std::uint32_t required_features = 0);
/// The required features that follow from the description alone: kShards, kDepths or none.
std::uint32_t required_features_of(const VersionDescription& version);
/// The optional features (manifest.h) whose fields encode_description() writes for this version.
std::uint32_t optional_features_of(const VersionDescription& version);

PLAIT_END_NAMESPACE
