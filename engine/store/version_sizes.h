// What the description of a version says about the sizes of its files, and what the disk has of
// them. A store is compared with both before a file is read whole or memory is taken for it, so
// forged sizes cost nothing.
#pragma once

#include <cstdint>
#include <filesystem>

#include "format/version_description.h"
#include "plait/extend/directory.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Throws unless a mesh can have these counts of vertices, edges and faces. Errors: kCorruption,
/// which names `path`.
void check_counts(const VersionDescription& description, const std::filesystem::path& path);

/// The bytes of all block tables. It follows from the counts alone. Errors: kCorruption, which
/// names `path`, for a level that is too large for a file.
std::uint64_t block_tables_bytes(const VersionDescription& description,
                                 const std::filesystem::path& path);

/// Throws if the files that are read whole, which are base mesh, version file and base records, are
/// large together and nearly all of that is holes. A store may have some: copies and file systems
/// make holes of zeros, so base records with the right checksum are not refused. Also throws for a
/// description of many shards whose block tables are holes or missing. Errors: kCorruption, which
/// names the file with most holes; kNotFound, kIo.
void refuse_holes(const Directory& store, const VersionDescription& description,
                  std::uint64_t sequence);

/// Throws if base mesh or base records have other sizes than the description says. For whoever will
/// refuse the store for it anyway, before a base mesh is decoded that the base records contradict.
/// Errors: kCorruption, which names the file.
void check_base_sizes(const Directory& store, const VersionDescription& description,
                      std::uint64_t sequence);

PLAIT_END_NAMESPACE
