// tests/acceptance/meshes.h: the meshes of the acceptance tests, and how much of them to run.
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

/// Six meshes of about so many vertices, the same on every machine: closed and open, of genus 0 and
/// more, of one and of many components, with one and with many border loops, valences 3 to 40.
/// Pinned by AcceptanceMeshes_*.
std::vector<AcceptanceMesh> generated_meshes(std::uint64_t vertices);

/// Six real ones, closed and open, of genus 0 to 43, of one and of 26 components, valences 2 to 26.
/// Those that are absent are skipped, and said to be.
std::vector<AcceptanceMesh> real_meshes();

/// PLAIT_ACCEPTANCE=full: hours instead of minutes.
inline bool is_full_run() {
  const char* value = std::getenv("PLAIT_ACCEPTANCE");
  return value != nullptr && std::string_view(value) == "full";
}

}  // namespace plait::test
