#include <cstdio>

#include "plait/create_store.h"
#include "plait/mesh_io.h"
#include "plait/reader.h"
#include "plait/subdivide.h"

int main() {
  plait::Store store = plait::create_store("first.plait", plait::read_base_mesh("molecule.ply"));
  plait::subdivide(store, {.levels = 3, .normals = true});
  store.commit();
  const plait::Reader reader(store);                       // one for all threads
  const plait::PatchView patch = reader.read_patch(0, 3);  // face 0, refined three times
  const auto [x, y, z] = patch.attribute<plait::Vector3<float>>("position").at(4, 0);
  std::printf("%g %g %g\n", x, y, z);  // the middle of the first side of face 0
}
