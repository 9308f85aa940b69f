#include "store/parts/shard_place.h"

#include "format/file_names.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Each level of raw blocks begins at a multiple of it, as O_DIRECT needs.
constexpr std::uint64_t kLevelAlignmentBytes = 4096;

std::uint64_t whole_alignments(std::uint64_t bytes) {
  return (bytes + kLevelAlignmentBytes - 1) / kLevelAlignmentBytes * kLevelAlignmentBytes;
}

std::uint64_t bytes_of_coarser_levels(const LevelGeometry& geometry) {
  std::uint64_t bytes = 0;
  for (BaseRelativeLevel level(1); level.refinements < geometry.level().refinements;
       ++level.refinements)
    bytes += whole_alignments(geometry.total_bytes_at(level));
  return bytes;
}

}  // namespace

void ShardPlace::put_into(LevelSpec& level) const {
  level.name = name;
  level.shares_file = shares_file;
  level.first_byte = first_byte;
}

std::uint64_t bytes_in_shared_file(const LevelGeometry& geometry) {
  return whole_alignments(geometry.total_bytes());
}

ShardPlace place_of(const ShardOfLevel& level, bool shares_files, const BackendTraits& traits) {
  return {
      shard_file_name(shares_files, level.attribute, level.level, level.generation, level.shard),
      shares_files,
      shares_files && traits.overwrites_in_place ? bytes_of_coarser_levels(level.geometry) : 0};
}

std::string shard_file_name(bool shares_files, std::uint32_t attribute, int level,
                            std::uint64_t generation, std::uint32_t shard) {
  return shares_files ? shard_file_name(attribute, generation, shard)
                      : level_file_name(attribute, level, generation, shard);
}

PLAIT_END_NAMESPACE
