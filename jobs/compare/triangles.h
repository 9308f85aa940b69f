// compare/triangles.h: the triangles of a mesh file or of a store, in memory.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "plait/base_mesh.h"
#include "plait/detail/namespace.h"
#include "plait/extend/backend_registry.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Reads a mesh file, or a level of a store (-1: the finest level of its positions). `warn` may be
/// empty. Errors: those of read_indexed_mesh() and Store::open(); kInvalidArgument for a level of a
/// file, a level that the store does not have, positions of another type, a face with a vertex that
/// is not there, and no face; kOutOfMemory if the memory of the machine is too small.
IndexedMesh read_triangles(const std::filesystem::path& path, int level,
                           const BackendRegistry& backends,
                           const std::function<void(const std::string&)>& warn);

PLAIT_END_NAMESPACE
