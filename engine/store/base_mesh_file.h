// The file base.mesh: the imported positions, and the faces in layout order. Byte table:
// docs/format.md.
#pragma once

#include <cstdint>

#include "plait/base_mesh.h"
#include "plait/directory.h"
#include "plait/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

struct StoredSize {
  std::uint64_t bytes = 0, checksum = 0;
};

/// Creates the file and syncs it.
StoredSize write_base_mesh_file(const Directory& store, const BaseMesh& mesh);

/// Errors: kCorruption for a wrong size, checksum or header, or a mesh that BaseMesh refuses.
BaseMesh read_base_mesh_file(const File& file, const StoredSize& expected);

PLAIT_END_NAMESPACE
