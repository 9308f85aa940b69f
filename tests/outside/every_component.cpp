// A program of somebody else's with something of each component of plait. It prints which version
// it was compiled against, and the digest of a store that it makes. CTest builds it in each way
// that docs/embedding.md tells of; all must print the same.
#include <cstdio>
#include <exception>
#include <string>

#include "plait/digest.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "plait/version.h"

int main() {
  try {
    const plait::BaseMesh octahedron = plait::BaseMesh::build(
        {.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0, 0, 3}, {0, 0, -3}},
         .faces = {{0, 2, 4},
                   {2, 1, 4},
                   {1, 3, 4},
                   {3, 0, 4},
                   {2, 0, 5},
                   {1, 2, 5},
                   {3, 1, 5},
                   {0, 3, 5}}});
    plait::StoreOptions options;
    options.backend = "memory";
    plait::Store store = plait::Store::create({}, octahedron, options, plait::default_backends());
    plait::add_base_positions(store);
    plait::subdivide(store, {.levels = 4, .normals = true});
    std::printf("plait %s %s\n", PLAIT_VERSION, plait::digest(store).to_string().c_str());
    // An exception of the library is caught by its type here, across the border of the library.
    try {
      plait::Store::open("no such store", {}, plait::default_backends());
    } catch (const plait::Error& error) {
      std::printf("%s\n", error.what());
      return 0;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  return 1;
}
