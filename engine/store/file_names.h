// The names of a store's files; docs/format.md, "Directory".
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace plait {

inline constexpr char kManifestName[] = "manifest";
inline constexpr char kBaseMeshName[] = "base.mesh";
inline constexpr char kLockName[] = "lock";
inline constexpr char kJournalName[] = "journal";

inline std::string level_file_name(std::uint32_t attribute, int level, std::uint64_t generation) {
  return fmt::format("attribute{}.level{:02}.{}", attribute, level, generation);
}
inline std::string base_file_name(std::uint32_t attribute, std::uint64_t version) {
  return fmt::format("attribute{}.base.{}", attribute, version);
}
inline std::string version_file_name(std::uint64_t version) {
  return fmt::format("version.{}", version);
}

/// The version that a file describes by its name; nothing for names of another kind.
std::optional<std::uint64_t> version_described_by(std::string_view name);

/// Whether a file of this name, a description or base records, belongs to this version alone.
bool is_of_version_alone(std::string_view name, std::uint64_t version);

/// Whether a name is one of those above, which versions come and go by.
bool is_version_file_name(std::string_view name);

}  // namespace plait
