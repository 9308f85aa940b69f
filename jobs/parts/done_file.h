// The file done.I of a plan, which says that part I is complete and what its files are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "parts/plan_file.h"
#include "plait/digest.h"
#include "store/parts/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr char kRecordsName[] = "records";  ///< of the base vertices, in a part
/// How often a reader of a part begins again because other processes make the part again.
inline constexpr int kMostReplacements = 100;

/// A complete part.
struct DoneFile {
  std::uint32_t part = 0;
  std::string directory;  ///< with the part's files
  /// PartContent::description, encoded; of a pass, its seal_of().
  std::vector<std::byte> description;
  std::vector<PartContent::FileOfPart> files;
  std::uint64_t tables_checksum = 0, records_checksum = 0;
  Digest digest;
  double seconds = 0;
  // Who made it, for people.
  std::string host, user;
  std::uint64_t begun = 0;  ///< seconds since 1970, UTC
  double cpu_seconds = 0;
  std::uint64_t peak_memory_bytes = 0;
};

/// The checksum of an encoded description.
std::vector<std::byte> seal_of(std::span<const std::byte> description);

/// Letters, digits and a few signs. Nothing else is in the name of a part's directory.
bool is_in_directory_names(char c);

std::string done_file_name(std::uint32_t part);
/// The names of the directories of this part begin with it.
std::string part_prefix(std::uint32_t part);
std::vector<std::byte> encode_done_file(const PlanFile& plan, const DoneFile& done);

/// The part if it is complete: done.I is of this plan and of this part, names the files that such a
/// part has, and they are there with their sizes, the tables with their checksum. Follows no link.
/// Nothing if there is no done.I. Reads a part again that is made again meanwhile. Errors:
/// kCorruption, which says what is wrong; kIo.
std::optional<DoneFile> read_done_part(const Directory& directory, const PlanFile& plan,
                                       std::uint32_t part);

/// What done.I says, whatever there is of its files. Errors: as read_done_part().
std::optional<DoneFile> read_done_file(const Directory& directory, const PlanFile& plan,
                                       std::uint32_t part);

PLAIT_END_NAMESPACE
