// Puts a mesh that does not fit into memory in the order of the Hilbert curve, and writes the files
// base.mesh and base.index of it: the same bytes as of a store whose mesh was laid out in memory.
// All that the way in memory looks up by number is here a sort of records.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "format/base_index_file.h"
#include "format/base_mesh_file.h"
#include "layout/external_sort.h"
#include "plait/extend/directory.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct FileLayoutRequest {
  std::filesystem::path mesh;  ///< a PLY file of triangles
  SortMemory memory;           ///< of all sorts at a time
  /// Hears the counts that the header promises, before anything is written.
  std::function<void(std::uint64_t vertices, std::uint64_t faces)> begin = {};
  /// Progress::done counts records of all passes.
  ProgressCallback progress = {};
};

struct FileLayoutResult {
  BaseCounts counts;
  std::uint64_t input_vertex_count = 0;
  StoredSize base_mesh;
  std::uint64_t merged_runs = 0;  ///< of all sorts, in all passes
  std::vector<std::string> warnings;
};

/// Makes both files in `directory`, and files without a name until the end. Errors: those of
/// stream_mesh() and of BaseMesh::build(); kNotSupported if faces must be turned to have one
/// orientation; kBudget if the corners of one vertex do not fit; kCancelled; kIo, kNoSpace.
/// Pinned by tests/jobs/layout_test.cpp.
FileLayoutResult lay_out_in_files(const FileLayoutRequest& request, const Directory& directory);

/// About how much disk lay_out_in_files() needs at a time, with its result.
std::uint64_t disk_need(std::uint64_t vertices, std::uint64_t faces, SortMemory memory);

PLAIT_END_NAMESPACE
