// The names of a store's files; docs/format.md, "Directory".
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr char kManifestName[] = "manifest";
inline constexpr char kBaseMeshName[] = "base.mesh";
/// What follows from base.mesh (format/base_index_file.h); and the name of the file while it is
/// written.
inline constexpr char kBaseIndexName[] = "base.index";
inline constexpr char kNewBaseIndexName[] = "base.index.new";
inline bool is_base_index_name(std::string_view name) {
  return name == kBaseIndexName || name == kNewBaseIndexName;
}
/// The finest level of each face (format/depths_file.h).
inline constexpr char kDepthsName[] = "depths";
inline constexpr char kLockName[] = "lock";

inline std::string level_file_name(std::uint32_t attribute, int level, std::uint64_t generation) {
  return fmt::format("attribute{}.level{:02}.{}", attribute, level, generation);
}
/// The file of all levels of an attribute in one shard.
inline std::string shard_file_name(std::uint32_t attribute, std::uint64_t generation,
                                   std::uint32_t shard) {
  return fmt::format("attribute{}.levels.{}.shard{}", attribute, generation, shard);
}
/// The file of one shard of a level, of stores whose shards have a file for each level.
inline std::string level_file_name(std::uint32_t attribute, int level, std::uint64_t generation,
                                   std::uint32_t shard) {
  return fmt::format("{}.shard{}", level_file_name(attribute, level, generation), shard);
}
inline std::string base_file_name(std::uint32_t attribute, std::uint64_t version) {
  return fmt::format("attribute{}.base.{}", attribute, version);
}
/// Of an attribute of the base faces.
inline std::string faces_file_name(std::uint32_t attribute, std::uint64_t version) {
  return fmt::format("attribute{}.faces.{}", attribute, version);
}
inline std::string version_file_name(std::uint64_t version) {
  return fmt::format("version.{}", version);
}

/// The change log that a version made (format/change_record.h).
inline std::string change_log_name(std::uint64_t generation) {
  return fmt::format("changes.{}", generation);
}
/// G for the name "changes.G"; nothing for other names.
std::optional<std::uint64_t> change_log_generation(std::string_view name);

/// The block tables of one shard.
inline std::string tables_file_name(std::uint64_t version, std::uint32_t shard) {
  return fmt::format("version.{}.shard{}", version, shard);
}

/// Bounds of the patches of an attribute (format/bounds_file.h); and the name of the file while it
/// is written.
inline std::string bounds_file_name(std::uint32_t attribute) {
  return fmt::format("attribute{}.bounds", attribute);
}
inline std::string new_bounds_file_name(std::uint32_t attribute) {
  return bounds_file_name(attribute) + ".new";
}
/// Whether the name is one of these two, of any attribute.
bool is_bounds_file_name(std::string_view name);

/// What a viewer needs for the first picture (format/view_file.h); and the page that draws it.
inline constexpr char kViewName[] = "view";
inline constexpr char kPageName[] = "index.html";
inline bool is_viewer_file_name(std::string_view name) {
  return name == kViewName || name == kPageName;
}

/// S for the name "version.S"; nothing for other names.
std::optional<std::uint64_t> version_described_by(std::string_view name);

/// Whether the file is version.S or has records of base vertices or faces of this version. No other
/// version needs such a file.
bool is_of_version_alone(std::string_view name, std::uint64_t version);

/// Whether a name is that of a file that a version adds or removes.
bool is_version_file_name(std::string_view name);

PLAIT_END_NAMESPACE
