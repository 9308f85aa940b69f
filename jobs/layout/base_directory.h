// A base mesh in files, which `plait layout` makes and other jobs take as their mesh: a directory
// with base.mesh and base.index, which stores copy as they are, and the file `layout`
// (docs/format.md).
#pragma once

#include <filesystem>
#include <memory>

#include "format/base_index_file.h"
#include "format/base_index_pages.h"
#include "format/base_mesh_file.h"
#include "plait/base_mesh.h"
#include "plait/extend/directory.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The order that all these meshes have.
inline constexpr LayoutKind kLayoutOfBaseDirectory = LayoutKind::kHilbert;

/// Writes the file `layout` and syncs it. Errors: kIo, kNoSpace.
void write_base_directory(const Directory& directory, const BaseCounts& counts,
                          const StoredSize& base_mesh);
/// Removes what a run makes in such a directory.
void remove_base_directory(const Directory& directory);

/// Whether the path is a directory with the file `layout`.
bool is_base_directory(const std::filesystem::path& path);
/// The arrays of the mesh, to be read by pages. Errors: as below.
std::shared_ptr<const BaseIndexPages> open_base_pages(const std::filesystem::path& path);
/// The mesh, whose arrays are read by pages. Errors: kCorruption for a damaged file; kNotFound,
/// kIo, kOutOfMemory.
BaseMesh open_base_directory(const std::filesystem::path& path);

PLAIT_END_NAMESPACE
