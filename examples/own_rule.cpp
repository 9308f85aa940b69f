// examples/own_rule.cpp: a subdivision rule of your own, in all three executors.
//
// A rule says in a few lines where vertices go: expressions over numbers of any type V, because
// plait evaluates them for one vertex, or for a register full of vertices at once. Every executor
// then gives the same bits, on every processor and with any compiler flags but -ffast-math.
// docs/schemes.md says what a rule must promise.
//
//   own_rule [W [LEVELS]]        W is the tension, 0.125 for Loop's own; without it 0.08, level 6
#include "plait/own_rule.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "plait/create_store.h"
#include "plait/digest.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace {

// Loop's rule with a tension: the smaller `w` is, the closer new vertices stay to their edges.
struct TensionRule {
  double w;

  template <class V>
  V odd(V a, V b, V c, V d) const {
    return (0.5 - w) * (a + b) + w * (c + d);
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
  template <class V>
  V even(V v, V ring) const {  // six new neighbours, whose sum is `ring`
    return 0.4 * v + 0.1 * ring;
  }
  template <class V>
  V even_border(V v, V p, V q) const {
    return 0.5 * v + 0.25 * (p + q);
  }
  double even_weight(int valence) const {  // of each new neighbour of a base vertex
    return 0.6 / valence;
  }
};

plait::BaseMesh octahedron() {
  plait::IndexedMesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.faces = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  return plait::BaseMesh::build(mesh);
}

std::string refine(const plait::OneRingScheme& scheme, plait::ExecutorKind executor, int levels) {
  plait::StoreOptions in_memory;
  in_memory.backend = "memory";
  plait::Store store = plait::create_store({}, octahedron(), in_memory);
  plait::SubdivideOptions options;
  options.scheme = scheme;
  options.executor = executor;
  options.levels = levels;
  options.normals = true;
  plait::subdivide(store, options);
  return plait::digest(store).to_string();
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const double w = count > 1 ? std::atof(arguments[1]) : 0.08;
    const int levels = count > 2 ? std::atoi(arguments[2]) : 6;
    const plait::OneRingScheme scheme = plait::own_scheme("tension", TensionRule{w});
    std::string first;
    bool same = true;
    for (const plait::ExecutorKind executor :
         {plait::ExecutorKind::kFused, plait::ExecutorKind::kSweep,
          plait::ExecutorKind::kTransparent}) {
      const std::string digest = refine(scheme, executor, levels);
      std::printf("%-12s %s\n", std::string(to_string(executor)).c_str(), digest.c_str());
      if (first.empty()) first = digest;
      same = same && digest == first;
    }
    std::puts(same ? "all executors agree bit for bit" : "they differ");
    return same ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "own_rule: %s\n", error.what());
    return 1;
  }
}
