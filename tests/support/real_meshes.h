// tests/support/real_meshes.h: meshes that are not part of the project. Tests use generated meshes
// where possible. If the machine has these meshes too, some tests also run on them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "support/sanitized.h"
#include "support/skip.h"

namespace plait::test {

inline std::filesystem::path real_mesh_path(std::string_view name) {
  return std::filesystem::path(PLAIT_MODELS_DIRECTORY) / (std::string(name) + ".ply");
}

/// Returns false, and skips the case or section, if the mesh is absent.
inline bool has_real_mesh(std::string_view name) {
  if (unless_sanitized(false, true)) {
    skip("real meshes take minutes under a sanitizer, for the same steps as shapes");
    return false;
  }
  if (std::filesystem::exists(real_mesh_path(name))) return true;
  skip("no " + real_mesh_path(name).string());
  return false;
}

}  // namespace plait::test
