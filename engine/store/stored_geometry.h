// The geometry of a level that a manifest names.
#pragma once

#include <fmt/format.h>

#include <filesystem>

#include "plait/base_mesh.h"
#include "plait/error.h"
#include "plait/level_geometry.h"
#include "store/manifest.h"

namespace plait {

/// Errors: kCorruption naming `path`, the manifest's, for a level that is too large to be.
inline LevelGeometry stored_geometry(const Manifest& manifest, const BaseMesh& base,
                                     const ManifestAttribute& attribute, int level,
                                     const std::filesystem::path& path) {
  try {
    return LevelGeometry(base.edge_count(), base.border_edges(),
                         relative_to_base(level, manifest.base_level),
                         attribute.schema.record_bytes(), manifest.block_bytes);
  } catch (const Error& error) {
    throw Error(ErrorCode::kCorruption, fmt::format("open {}: attribute '{}': {}", path.native(),
                                                    attribute.schema.name, error.what()));
  }
}

}  // namespace plait
