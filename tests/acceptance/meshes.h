// tests/acceptance/meshes.h: the meshes of the acceptance tests, and the switch for full runs.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "plait/base_mesh.h"

namespace plait::test {

struct AcceptanceMesh {
  std::string name;
  std::function<IndexedMesh()> make;
};

/// Six meshes of about `vertices` vertices, the same on every machine: closed and open, of genus 0
/// and more, of one and of many components, with one and with many border loops, with valences 3 to
/// 40.
/// Pinned by AcceptanceMeshes_*.
std::vector<AcceptanceMesh> generated_meshes(std::uint64_t vertices);

/// Six real meshes, closed and open, of genus 0 to 43, of one and of 26 components, with valences 2
/// to 26. Skips those that the machine does not have, and prints their names.
std::vector<AcceptanceMesh> real_meshes();

/// With PLAIT_ACCEPTANCE=full the tests take hours instead of minutes.
inline bool is_full_run() {
  const char* value = std::getenv("PLAIT_ACCEPTANCE");
  return value != nullptr && std::string_view(value) == "full";
}

}  // namespace plait::test
