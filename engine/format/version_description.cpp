#include "format/version_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <set>

#include "format/field_stream.h"
#include "format/manifest.h"
#include "format/optional_fields.h"
#include "plait/detail/edge_shards.h"
#include "plait/error.h"
#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint8_t kLimitPositions = 1;  ///< a bit of the provenance's flags
/// The size of an attribute without levels, with empty texts.
constexpr std::size_t kLeastAttributeBytes = 30;

bool is_same_range(const LevelRecord& a, const LevelRecord& b) {
  return a.pipeline == b.pipeline && a.representation == b.representation;
}

/// The sizes of the ranges of consecutive levels that have the same pipeline and representation.
std::vector<std::size_t> range_sizes(const std::vector<LevelRecord>& levels) {
  std::vector<std::size_t> sizes;
  for (std::size_t at = 0; at < levels.size(); ++at)
    if (at > 0 && is_same_range(levels[at - 1], levels[at]))
      ++sizes.back();
    else
      sizes.push_back(1);
  return sizes;
}

void encode_attribute(const AttributeRecord& attribute, FieldWriter& fields) {
  if (!is_attribute_name(attribute.schema.name))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("describe version: '{}' is no attribute name",
                            attribute.schema.name.substr(0, kMaxAttributeNameBytes)));
  fields.put_text(attribute.schema.name, kMaxAttributeNameBytes, "an attribute's name");
  fields.put(attribute.number);
  fields.put(static_cast<std::uint8_t>(attribute.schema.type));
  fields.put(static_cast<std::uint8_t>(attribute.schema.components));
  fields.put(attribute.base_bytes);
  fields.put(attribute.base_checksum);
  fields.put_text(attribute.pipeline.to_text(), kMaxTextBytes, "an attribute's pipeline");
  fields.put(static_cast<std::uint32_t>(attribute.levels.size()));
  const std::vector<std::size_t> sizes = range_sizes(attribute.levels);
  fields.put(static_cast<std::uint32_t>(sizes.size()));
  std::size_t first = 0;
  for (const std::size_t size : sizes) {
    const LevelRecord& level = attribute.levels[first];
    fields.put(static_cast<std::uint32_t>(size));
    fields.put(static_cast<std::uint32_t>(level.representation));
    fields.put_text(level.pipeline.to_text(), kMaxTextBytes, "a level's pipeline");
    first += size;
  }
  for (const LevelRecord& level : attribute.levels) {
    fields.put(level.generation);
    fields.put(std::uint32_t{0});
  }
}

/// Another program may know text that is no pipeline here, so this is no corruption.
template <class Value>
Value take_pipeline(FieldReader& fields, std::string_view field,
                    const std::filesystem::path& path) {
  const std::string text = fields.take_text(kMaxTextBytes, field);
  try {
    return Value(text);
  } catch (const Error& error) {
    throw Error(ErrorCode::kNotSupported,
                fmt::format("open {}: {}: {}", path.native(), field, error.what()));
  }
}

/// Decodes one attribute after another, and checks that their names and numbers differ.
class AttributeDecoder {
 public:
  AttributeDecoder(FieldReader& fields, const VersionDescription& version, std::uint64_t sequence,
                   const std::filesystem::path& path)
      : fields_(fields), version_(version), sequence_(sequence), path_(path) {}

  AttributeRecord next() {
    AttributeRecord attribute;
    AttributeSchema& schema = attribute.schema;
    schema.name = fields_.take_text(kMaxAttributeNameBytes, "an attribute's name");
    fields_.require(is_attribute_name(schema.name), "an attribute's name", schema.name);
    fields_.require(names_.insert(schema.name).second, "a repeated attribute name", schema.name);
    attribute.number = fields_.take<std::uint32_t>("an attribute's number");
    fields_.require(attribute.number < version_.next_attribute_number &&
                        numbers_.insert(attribute.number).second,
                    "an attribute's number", attribute.number);
    schema.type = static_cast<ComponentType>(fields_.take<std::uint8_t>("a component type"));
    schema.components = fields_.take<std::uint8_t>("a number of components");
    fields_.require(schema.record_bytes() > 0, "a record's size", 0);
    attribute.base_bytes = fields_.take<std::uint64_t>("the size of base records");
    fields_.require(attribute.base_bytes <= version_.vertex_count * schema.record_bytes(),
                    "the size of base records", attribute.base_bytes);
    attribute.base_checksum = fields_.take<std::uint64_t>("a checksum of base records");
    attribute.pipeline = take_pipeline<LevelPipelines>(fields_, "an attribute's pipeline", path_);
    take_levels(attribute);
    return attribute;
  }

 private:
  void take_levels(AttributeRecord& attribute) {
    const auto count = fields_.take<std::uint32_t>("a number of levels");
    const int base_level = version_.provenance.base_level;
    fields_.require(count <= static_cast<std::uint32_t>(kMaxLevel - base_level),
                    "a number of levels", count);
    const auto ranges = fields_.take<std::uint32_t>("a number of ranges of levels");
    fields_.require(ranges <= count, "a number of ranges of levels", ranges);
    for (std::uint32_t range = 0; range < ranges; ++range) {
      const auto size = fields_.take<std::uint32_t>("the size of a range of levels");
      fields_.require(size > 0 && size <= count - attribute.levels.size(),
                      "the size of a range of levels", size);
      LevelRecord level;
      level.representation = take_representation(attribute);
      level.pipeline = take_pipeline<Pipeline>(fields_, "a level's pipeline", path_);
      attribute.levels.insert(attribute.levels.end(), size, level);
    }
    fields_.require(attribute.levels.size() == count, "the number of levels in all ranges",
                    attribute.levels.size());
    for (LevelRecord& level : attribute.levels) take_generation(level);
  }

  void take_generation(LevelRecord& level) {
    level.generation = fields_.take<std::uint64_t>("a level's generation");
    fields_.require(level.generation > 0 && level.generation <= sequence_, "a level's generation",
                    level.generation);
    const auto other_files = fields_.take<std::uint32_t>("a level's other files");
    fields_.require(other_files == 0, "a level's other files", other_files);
  }

  Representation take_representation(const AttributeRecord& attribute) {
    const auto found = fields_.take<std::uint32_t>("a representation");
    if (found == static_cast<std::uint32_t>(Representation::kValues))
      return Representation::kValues;
    throw Error(
        ErrorCode::kNotSupported,
        fmt::format("open {}: attribute '{}' has level {} in representation {}, and plait "
                    "{} knows only 0, the values themselves",
                    path_.native(), attribute.schema.name,
                    version_.provenance.base_level + 1 + static_cast<int>(attribute.levels.size()),
                    found, program_version()));
  }

  FieldReader& fields_;
  const VersionDescription& version_;
  std::uint64_t sequence_;
  const std::filesystem::path& path_;
  std::set<std::string> names_;
  std::set<std::uint32_t> numbers_;
};

void encode_shards(const VersionDescription& version, FieldWriter& fields) {
  fields.put(static_cast<std::uint32_t>(version.shards.size()));
  for (const ShardRecord& shard : version.shards) {
    fields.put(shard.first_edge);
    fields.put(shard.tables_checksum);
  }
}

void take_shards(FieldReader& fields, VersionDescription& version) {
  const auto count = fields.take<std::uint32_t>("the number of shards");
  fields.require(count > 0 && count <= kMostShards &&
                     count <= fields.bytes_left() / (sizeof(std::uint32_t) + sizeof(std::uint64_t)),
                 "the number of shards", count);
  for (std::uint32_t at = 0; at < count; ++at) {
    const auto first = fields.take<std::uint32_t>("the first edge of a shard");
    const bool ascends = at == 0 ? first == 0 : first > version.shards.back().first_edge;
    fields.require(ascends && first < version.edge_count, "the first edge of a shard", first);
    version.shards.push_back(
        {first, fields.take<std::uint64_t>("a checksum of block tables of a shard")});
  }
}

void encode_depths(const DepthsRecord& depths, FieldWriter& fields) {
  fields.put(depths.checksum);
  fields.put(static_cast<std::uint32_t>(depths.slots.size()));
  for (const std::uint32_t slots : depths.slots) fields.put(slots);
}

void take_depths(FieldReader& fields, VersionDescription& version) {
  fields.require(version.shards.empty(), "depths of levels in shards", "there");
  DepthsRecord& depths = version.depths.emplace();
  depths.checksum = fields.take<std::uint64_t>("the checksum of the depths");
  const auto levels = fields.take<std::uint32_t>("the number of levels of the deepest face");
  fields.require(levels <= static_cast<std::uint32_t>(kMaxLevel - version.provenance.base_level),
                 "the number of levels of the deepest face", levels);
  for (std::uint32_t level = 0; level < levels; ++level) {
    const auto slots = fields.take<std::uint32_t>("the number of slots of a level");
    // A face has the levels before each level that it has.
    fields.require(slots > 0 && slots <= (level == 0 ? version.edge_count : depths.slots.back()),
                   "the number of slots of a level", slots);
    depths.slots.push_back(slots);
  }
  for (const AttributeRecord& attribute : version.attributes)
    fields.require(attribute.levels.size() <= levels, "a number of levels beyond all depths",
                   attribute.levels.size());
}

}  // namespace

std::uint32_t required_features_of(const VersionDescription& version) {
  return (version.shards.empty() ? 0 : std::uint32_t{kShards}) |
         (!version.shards.empty() && version.shares_files ? std::uint32_t{kSharedFiles} : 0) |
         (version.depths ? std::uint32_t{kDepths} : 0);
}

bool is_attribute_name(std::string_view name) {
  return name.size() <= kMaxAttributeNameBytes && is_stage_name(name);
}

std::vector<std::byte> encode_description(const VersionDescription& version) {
  if (version.attributes.size() > kMaxAttributes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("describe version: expected at most {} attributes, found {}",
                            kMaxAttributes, version.attributes.size()));
  const Provenance& provenance = version.provenance;
  FieldWriter fields;
  for (const std::uint64_t number :
       {version.vertex_count, version.edge_count, version.face_count, version.border_edge_count,
        version.block_bytes, version.base_mesh_bytes, version.base_mesh_checksum})
    fields.put(number);
  fields.put(static_cast<std::uint32_t>(provenance.base_level));
  fields.put(version.next_attribute_number);
  fields.put_text(version.backend, kMaxTextBytes, "the backend");
  fields.put_text(version.pipeline.to_text(), kMaxTextBytes, "the pipeline");
  fields.put_text(provenance.layout, kMaxTextBytes, "the layout");
  fields.put_text(provenance.scheme, kMaxTextBytes, "the scheme");
  fields.put_text(provenance.program, kMaxTextBytes, "the program's version");
  fields.put(provenance.limit ? kLimitPositions : std::uint8_t{0});
  fields.put(static_cast<std::uint8_t>(provenance.precision));
  fields.put(static_cast<std::uint32_t>(version.attributes.size()));
  for (const AttributeRecord& attribute : version.attributes) encode_attribute(attribute, fields);
  encode_optional_fields(version, fields);
  if (!version.shards.empty()) encode_shards(version, fields);
  if (version.depths) encode_depths(*version.depths, fields);
  std::vector<std::byte> bytes = fields.take();
  if (bytes.size() > kMaxDescriptionBytes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("describe version: expected at most {} bytes, found {}",
                            kMaxDescriptionBytes, bytes.size()));
  return bytes;
}

VersionDescription decode_description(std::span<const std::byte> bytes, std::uint64_t sequence,
                                      const std::filesystem::path& path,
                                      std::uint32_t optional_features,
                                      std::uint32_t required_features) {
  FieldReader fields(bytes, path);
  VersionDescription version;
  Provenance& provenance = version.provenance;
  const auto take_count = [&](std::string_view field) {
    const auto count = fields.take<std::uint64_t>(field);
    fields.require(count < kNoId, field, count);
    return count;
  };
  version.vertex_count = take_count("the vertex count");
  version.edge_count = take_count("the edge count");
  version.face_count = take_count("the face count");
  version.border_edge_count = take_count("the border edge count");
  version.block_bytes = fields.take<std::uint64_t>("the block size");
  fields.require(std::has_single_bit(version.block_bytes) && version.block_bytes >= 4096 &&
                     version.block_bytes <= (1u << 30),
                 "the block size", version.block_bytes);
  version.base_mesh_bytes = fields.take<std::uint64_t>("the size of the base mesh");
  version.base_mesh_checksum = fields.take<std::uint64_t>("the checksum of the base mesh");
  const auto base_level = fields.take<std::uint32_t>("the base level");
  fields.require(base_level <= kMaxLevel, "the base level", base_level);
  provenance.base_level = static_cast<int>(base_level);
  version.next_attribute_number = fields.take<std::uint32_t>("the next attribute number");
  version.backend = fields.take_text(kMaxTextBytes, "the backend");
  version.pipeline = take_pipeline<LevelPipelines>(fields, "the pipeline", path);
  provenance.layout = fields.take_text(kMaxTextBytes, "the layout");
  provenance.scheme = fields.take_text(kMaxTextBytes, "the scheme");
  provenance.program = fields.take_text(kMaxTextBytes, "the program's version");
  provenance.limit = (fields.take<std::uint8_t>("the provenance's flags") & kLimitPositions) != 0;
  const auto precision = fields.take<std::uint8_t>("the precision");
  provenance.precision = static_cast<ComponentType>(precision);
  fields.require(provenance.precision == ComponentType::kFloat32 ||
                     provenance.precision == ComponentType::kFloat64,
                 "the precision", precision);
  const auto count = fields.take<std::uint32_t>("the number of attributes");
  fields.require(count <= kMaxAttributes && count <= fields.bytes_left() / kLeastAttributeBytes,
                 "the number of attributes", count);
  AttributeDecoder attributes(fields, version, sequence, path);
  for (std::uint32_t at = 0; at < count; ++at) version.attributes.push_back(attributes.next());
  take_optional_fields(fields, version, optional_features);
  if ((required_features & kShards) != 0) take_shards(fields, version);
  version.shares_files = (required_features & kSharedFiles) != 0;
  fields.require(!version.shares_files || !version.shards.empty(), "files of several levels",
                 "no shards");
  if ((required_features & kDepths) != 0) take_depths(fields, version);
  return version;
}

PLAIT_END_NAMESPACE
