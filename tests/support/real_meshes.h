// tests/support/real_meshes.h: meshes that are not part of the project. What can be shown on
// generated meshes is; these come on top where they are.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "support/skip.h"

namespace plait::test {

inline std::filesystem::path real_mesh_path(std::string_view name) {
  return std::filesystem::path(PLAIT_MODELS_DIRECTORY) / (std::string(name) + ".ply");
}

/// False where the mesh is absent, and the case or section is skipped.
inline bool has_real_mesh(std::string_view name) {
  if (std::filesystem::exists(real_mesh_path(name))) return true;
  skip("no " + real_mesh_path(name).string());
  return false;
}

}  // namespace plait::test
