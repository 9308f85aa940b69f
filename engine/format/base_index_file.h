// The optional file base.index: what BaseMesh::build() computes from base.mesh, as arrays that
// nobody needs to compute again. docs/format.md, "base.index". No version names the file; its head
// has the checksum of the base.mesh that it follows from.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/damage.h"
#include "format/base_index_layout.h"
#include "plait/base_mesh.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// A store gets the file for a mesh of this number of faces or more, unless its options say
/// otherwise. A smaller one is computed in less time than a person or a disk notices.
inline constexpr std::uint64_t kFacesForIndex = 1u << 14;

/// `wish` is the option base_index.
inline bool wants_index(std::optional<bool> wish, const BaseMesh& mesh) {
  return wish.value_or(mesh.face_count() >= kFacesForIndex);
}

/// Creates the file with the given name. `base_mesh_checksum` is that of base.mesh. Errors: kIo,
/// kNoSpace; those of the mesh.
void write_base_index_file(const Directory& in, const std::string& name, const BaseMesh& mesh,
                           std::uint64_t base_mesh_checksum, bool durable);

/// Writes the file under another name, then renames it: after a crash there is no such file, or the
/// whole one. REQUIRES: the caller has the writer's lock. Errors: kIo, kNoSpace; those of the mesh.
void add_base_index_file(const Directory& store, const BaseMesh& mesh,
                         std::uint64_t base_mesh_checksum, bool durable);

/// What the version says of the base mesh.
struct ExpectedBase {
  BaseCounts counts;
  std::uint64_t checksum = 0;  ///< of base.mesh
  /// What helps if the file is damaged, for messages. Lives as long as the program.
  std::string_view cure = kDamageCure;
};

/// The mesh of the file, which is read by pages when they are needed: now only its head and its
/// border edges. Nothing if there is no file. Takes memory for what is read; addresses for the
/// whole file. Errors: kCorruption for another size or head; kIo, kOutOfMemory.
std::optional<BaseMesh> open_base_index_file(const Directory& store, const ExpectedBase& expected);

/// The first bytes of the file, up to the checksum of these: head_bytes() of the layout.
/// `checksums` are those of the pages.
std::vector<std::byte> base_index_head(const BaseCounts& counts, IndexMaps maps,
                                       std::uint64_t input_vertex_count,
                                       std::uint64_t base_mesh_checksum,
                                       std::span<const std::uint64_t> checksums);

/// Throws kCorruption unless the file has exactly what write_base_index_file() writes for this
/// mesh, or there is no file. `mesh` was built from base.mesh; nullptr if base.mesh is damaged, and
/// then only checksums are compared. Errors: kIo, kOutOfMemory.
void check_base_index_file(const Directory& store, const ExpectedBase& expected,
                           const BaseMesh* mesh);

PLAIT_END_NAMESPACE
