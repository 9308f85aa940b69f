// tools/resume.h: a subdivision that commits every level and can go on where it was interrupted.
#pragma once

#include <filesystem>

#include "plait/kernels/subdivide.h"
#include "plait/layout.h"
#include "plait/store.h"

namespace plait {

/// Opens the store of an earlier run for going on. Errors: as Store::open; kInvalidArgument if it
/// is not the beginning of this subdivision: another scheme or precision, limit positions, finer
/// than `subdivision.levels`, or finished with normals at a coarser level.
Store open_to_resume(const std::filesystem::path& path, const OpenOptions& open,
                     const SubdivideOptions& subdivision, bool double_precision,
                     const BackendRegistry& backends);

/// Errors: kInvalidArgument if the store's base mesh is not `mesh`, laid out as the store is.
void require_same_mesh(const Store& store, const BaseMesh& mesh);

/// Whether nothing of the subdivision is left to do.
bool is_finished(const Store& store, const SubdivideOptions& subdivision);

}  // namespace plait
