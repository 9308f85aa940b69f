// The files of a plan: `plan`, which never changes, and done.I, which says that part I is complete
// and what its files are. Both end with their checksum, so a file that is cut is recognised.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "format/base_mesh_file.h"
#include "plait/digest.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/parts.h"
#include "store/part_store.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

inline constexpr char kPlanName[] = "plan";
inline constexpr char kRecordsName[] = "records";  ///< of the base vertices, in a part

/// All that the file says.
struct PlanFile {
  PartsPlan plan;
  std::uint64_t checksum = 0;  ///< of the file
  std::uint64_t vertex_count = 0, edge_count = 0, face_count = 0;
  StoredSize base_mesh;
  std::string scheme, layout;
  ComponentType precision = ComponentType::kFloat32;
  bool normals = false, limit = false;
  std::uint64_t block_bytes = 0;
  std::string position_pipeline, normal_pipeline;  ///< empty: the backend's default

  std::vector<EdgeId> starts() const;
};

void write_plan_file(const Directory& directory, const PlanFile& plan);
/// Errors: kNotFound, kCorruption, kIo.
PlanFile read_plan_file(const Directory& directory);

/// Opens the directory of a plan. Errors: kNotFound if it is none.
Directory open_plan_directory(const std::filesystem::path& plan);

/// A complete part.
struct DoneFile {
  std::uint32_t part = 0;
  std::string directory;               ///< with the part's files
  std::vector<std::byte> description;  ///< PartContent::description, encoded
  std::vector<PartContent::LevelOfPart> levels;
  std::uint64_t tables_checksum = 0, records_checksum = 0;
  Digest digest;
  double seconds = 0;
};

/// Letters, digits and a few signs. Nothing else is in the name of a part's directory.
bool is_in_directory_names(char c);

/// Errors: kCorruption for a file of more than 256 MiB of which less than 1/64 is on the disk, as
/// for a store.
void refuse_hole(const File& file);

std::string done_file_name(std::uint32_t part);
/// The names of the directories of this part begin with it.
std::string part_prefix(std::uint32_t part);
std::vector<std::byte> encode_done_file(const PlanFile& plan, const DoneFile& done);

/// The part if it is complete: done.I is of this plan and of this part, names the files that such a
/// part has, and they are there with their sizes, the tables with their checksum. Follows no link.
/// Nothing if there is no done.I. Errors: kCorruption, which says what is wrong; kIo.
std::optional<DoneFile> read_done_part(const Directory& directory, const PlanFile& plan,
                                       std::uint32_t part);

PLAIT_END_NAMESPACE
