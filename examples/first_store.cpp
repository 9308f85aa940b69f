#include <cstdio>
#include <filesystem>

#include "plait/layout.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/registry.h"
#include "plait/subdivide.h"

int main() {
  std::filesystem::remove_all("first.plait");  // of an earlier run
  plait::Store store = plait::Store::create(
      "first.plait",
      plait::lay_out(plait::read_base_mesh("molecule.ply"), plait::LayoutKind::kAutomatic),
      {.budget_bytes = 64 << 20}, plait::default_backends());
  plait::add_base_positions(store);
  plait::subdivide(store, {.levels = 3, .normals = true});
  store.commit();

  const plait::Reader reader(store);                       // one for all threads
  const plait::PatchView patch = reader.read_patch(0, 3);  // face 0, refined three times
  const auto position = patch.attribute<plait::Vector3<float>>("position");
  const auto& [x, y, z] = position.at(patch.size() / 2, 0);  // the middle of its first side
  std::printf("%g %g %g\n", x, y, z);
}
