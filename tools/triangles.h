// tools/triangles.h: the triangles of a mesh file or of a store, in memory.
#pragma once

#include <filesystem>

#include "plait/base_mesh.h"
#include "plait/extend/backend_registry.h"

namespace plait {

/// Reads a mesh file, or a level of a store (-1: the finest level of its positions). Warnings of
/// the file go to standard error. Errors: those of read_indexed_mesh() and Store::open();
/// kInvalidArgument for a level of a file, a level that the store does not have, and positions of
/// another type; kOutOfMemory if the memory of the machine is too small.
IndexedMesh read_triangles(const std::filesystem::path& path, int level,
                           const BackendRegistry& backends);

}  // namespace plait
