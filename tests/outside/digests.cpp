// A program of somebody else's: refines two meshes by loops of its own, by the library's loops
// compiled here, and by the library's executors, with the library's rules and with one of its own,
// and prints a digest of each. CTest builds it
// twice, as plait builds itself and as a project outside does that lets the compiler contract; both
// must print the same lines (compare.cmake), and each fails by itself where its digests differ.
#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "plait/digest.h"
#include "plait/extend/patch.h"
#include "plait/extend/rule_patches.h"
#include "plait/own_rule.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"

namespace {

using plait::ExecutorKind;
using plait::FaceId;
using plait::Vector3;
using plait::VertexId;

constexpr int kLevels = 4;

/// A number in [0, 1) that depends on all bits of `seed`.
double noise(std::uint64_t seed) {
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebu;
  return double((seed ^ (seed >> 31)) >> 11) * 0x1p-53;
}

/// `side` x `side` squares, each cut along one diagonal or the other, so of many valences: a torus,
/// or a sheet with a border.
plait::BaseMesh squares(VertexId side, bool closed) {
  const VertexId points = closed ? side : side + 1;
  plait::IndexedMesh mesh;
  for (VertexId row = 0; row < points; ++row)
    for (VertexId column = 0; column < points; ++column) {
      const VertexId seed = 3 * (row * points + column) + 1;
      mesh.positions.push_back({row + noise(seed), column + noise(seed + 1), 3 * noise(seed + 2)});
    }
  const auto at = [&](VertexId row, VertexId column) {
    return row % points * points + column % points;
  };
  for (VertexId row = 0; row < side; ++row)
    for (VertexId column = 0; column < side; ++column) {
      const VertexId a = at(row, column), b = at(row + 1, column), c = at(row + 1, column + 1),
                     d = at(row, column + 1);
      if (noise(1000 * row + column) < 0.5) {
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({a, c, d});
      } else {
        mesh.faces.push_back({a, b, d});
        mesh.faces.push_back({b, c, d});
      }
    }
  return plait::BaseMesh::build(mesh);
}

plait::Store scratch_store(const plait::BaseMesh& base, bool double_precision) {
  plait::StoreOptions options;
  options.backend = "memory";
  plait::Store store = plait::Store::create({}, base, options, plait::default_backends());
  plait::add_base_positions(
      store, double_precision ? plait::ComponentType::kFloat64 : plait::ComponentType::kFloat32);
  return store;
}

/// Whether this face computes a point of its grid that is no corner: on an edge only one face does.
template <class Patch>
bool computes(const Patch& patch, std::int64_t size, std::int64_t i, std::int64_t j) {
  return i + j == size ? patch.owns(0) : i == 0 ? patch.owns(1) : j == 0 ? patch.owns(2) : true;
}
template <class Patch>
bool on_border(const Patch& patch, std::int64_t size, std::int64_t i, std::int64_t j) {
  return (i + j == size && patch.is_border(0)) || (i == 0 && patch.is_border(1)) ||
         (j == 0 && patch.is_border(2));
}

template <class Mesh>
const auto& loop_of() {
  return plait::loop_scheme().rule<decltype(Mesh::Record::x)>();
}

/// This program's own loops, with the library's rules.
struct OwnLoops {
  /// A point born at `level`: the middle of an edge that runs along i, along j or across.
  template <class Patch, class Rule>
  static void make_odd(const Rule& rule, const Patch& patch, int level, std::int64_t i,
                       std::int64_t j) {
    const std::int64_t size = std::int64_t{1} << level;
    if (!computes(patch, size, i, j)) return;
    const std::int64_t along_i = j % 2 == 0 ? 1 : i % 2 == 0 ? 0 : 1;
    const std::int64_t along_j = j % 2 == 0 ? 0 : i % 2 == 0 ? 1 : -1;
    const auto coarse = [&](std::int64_t p, std::int64_t q) -> auto& {
      return patch.at(level - 1, (i + p) / 2, (j + q) / 2);
    };
    const auto& a = coarse(-along_i, -along_j);
    const auto& b = coarse(along_i, along_j);
    auto& made = patch.at(level, i, j);
    if (on_border(patch, size, i, j))
      made = rule.odd_border(a, b);
    else if (along_j == 0)
      made = rule.odd(a, b, coarse(-1, 2), coarse(1, -2));
    else if (along_i == 0)
      made = rule.odd(a, b, coarse(2, -1), coarse(-2, 1));
    else
      made = rule.odd(a, b, coarse(-1, -1), coarse(1, 1));
  }

  template <class Patch, class Rule>
  static void move_even(const Rule& rule, const Patch& patch, int level, std::int64_t i,
                        std::int64_t j) {
    const std::int64_t size = std::int64_t{1} << level;
    if (plait::is_corner(level, i, j) || !computes(patch, size, i, j)) return;
    const auto near = [&](std::int64_t p, std::int64_t q) -> auto& {
      return patch.at(level, i + p, j + q);
    };
    auto& v = near(0, 0);
    if (!on_border(patch, size, i, j))
      v = rule.even(v, plait::ring_sum(near(-1, 1), near(-1, 0), near(0, -1), near(1, -1),
                                       near(1, 0), near(0, 1)));
    else if (j == 0)
      v = rule.even_border(v, near(-1, 0), near(1, 0));
    else if (i == 0)
      v = rule.even_border(v, near(0, -1), near(0, 1));
    else
      v = rule.even_border(v, near(1, -1), near(-1, 1));
  }

  template <plait::PatchMesh Mesh>
  static void refine(Mesh& mesh, int level) {
    const auto& rule = loop_of<Mesh>();
    const plait::Topology topology = mesh.topology();
    const std::int64_t size = std::int64_t{1} << level;
    plait::RingTable<typename Mesh::Record> rings(topology.edges.size());
    mesh.activate(level, level, level);
    for (FaceId face = 0; face < topology.faces.size(); ++face) {
      const auto patch = mesh.patch(face);
      for (std::int64_t j = 0; j <= size; ++j)
        for (std::int64_t i = 0; i + j <= size; ++i)
          if (i % 2 + j % 2 > 0) make_odd(rule, patch, level, i, j);
      plait::collect_rings(patch, topology, level, rings);
    }
    mesh.activate(level, 1, level - 1);
    for (FaceId face = 0; face < topology.faces.size(); ++face) {
      const auto patch = mesh.patch(face);
      for (std::int64_t j = 0; j <= size; j += 2)
        for (std::int64_t i = 0; i + j <= size; i += 2) move_even(rule, patch, level, i, j);
    }
    plait::move_base_vertices(topology, rings, rule, mesh.base_records());
  }
};

/// A rule of this program's own, full of products that a compiler would like to contract with the
/// sums around them.
struct OwnRule {
  double w = 0.13;

  template <class V>
  V odd(V a, V b, V c, V d) const {
    return 0.37 * (a + b) + w * (c + d);
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.51 * (a + b);
  }
  template <class V>
  V even(V v, V ring) const {
    return 0.4 * v + 0.1 * ring;
  }
  template <class V>
  V even_border(V v, V p, V q) const {
    return 0.6 * v + 0.2 * (p + q);
  }
  double even_weight(int valence) const { return 0.6 / valence; }
  template <class V>
  V limit(V v, V ring) const {
    return 0.3 * v + ring / 9;
  }
  template <class V>
  V limit_border(V v, V p, V q) const {
    return (3 * v + (p + q)) / 5;
  }
  double limit_weight(int valence) const { return 1.0 / (valence + 3); }
};

/// The library's loops, compiled with this program's flags.
struct LibraryLoops {
  template <plait::PatchMesh Mesh>
  static void refine(Mesh& mesh, int level) {
    plait::refine_patches(mesh, level, loop_of<Mesh>());
  }
};

template <class Loops, class Real>
std::string by_loops(const plait::BaseMesh& base) {
  plait::Store store = scratch_store(base, sizeof(Real) == 8);
  const plait::AttributeId position = store.attribute("position");
  plait::StorePatches<Vector3<Real>> patches(store, position, 16 << 20);
  for (int level = 1; level <= kLevels; ++level) {
    store.add_level(position);
    Loops::refine(patches, level);
  }
  return plait::digest(store).to_string();
}

std::string by_executor(const plait::BaseMesh& base, bool double_precision,
                        plait::SubdivideOptions options, ExecutorKind executor) {
  plait::Store store = scratch_store(base, double_precision);
  options.levels = kLevels;
  options.executor = executor;
  plait::subdivide(store, options);
  return plait::digest(store).to_string();
}

/// Whether all digests are alike; prints them.
class Line {
 public:
  explicit Line(std::string what) : what_(std::move(what)) {}
  void add(const char* who, const std::string& digest) {
    std::printf("%-32s %-16s %s\n", what_.c_str(), who, digest.c_str());
    if (first_.empty()) first_ = digest;
    same_ = same_ && digest == first_;
  }
  bool same() const { return same_; }

 private:
  std::string what_, first_;
  bool same_ = true;
};

template <class Real>
bool run(const plait::BaseMesh& base, const std::string& name) {
  constexpr bool double_precision = sizeof(Real) == 8;
  const std::array<std::pair<const char*, ExecutorKind>, 3> executors = {
      {{"sweep", ExecutorKind::kSweep},
       {"transparent", ExecutorKind::kTransparent},
       {"fused", ExecutorKind::kFused}}};
  bool same = true;
  const auto check = [&](const std::string& what, const plait::SubdivideOptions& options,
                         bool loops) {
    Line line(name + (double_precision ? ", float64, " : ", float32, ") + what);
    for (const auto& [who, executor] : executors)
      line.add(who, by_executor(base, double_precision, options, executor));
    if (loops) {
      line.add("library's loops", by_loops<LibraryLoops, Real>(base));
      line.add("own loops", by_loops<OwnLoops, Real>(base));
    }
    same = same && line.same();
  };
  check("Loop", {}, true);
  plait::SubdivideOptions surface;
  surface.normals = surface.limit = true;
  check("normals and limit", surface, false);
  plait::SubdivideOptions butterfly;
  butterfly.scheme = plait::Scheme::kButterfly;
  butterfly.normals = true;
  check("Butterfly", butterfly, false);
  const plait::OneRingScheme own = plait::own_scheme("own", OwnRule{});
  plait::SubdivideOptions by_own_rule;
  by_own_rule.scheme = own;
  check("own rule", by_own_rule, false);
  by_own_rule.limit = by_own_rule.normals = true;
  check("own rule, limit", by_own_rule, false);
  return same;
}

}  // namespace

/// Whether this processor has what the project outside compiles for.
bool runs_here() {
#if defined(__x86_64__) && defined(__FMA__)
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return true;
#endif
}

int main() {
  if (!runs_here()) {
    std::puts("skipped: this processor has no fused multiply-add");
    return 77;
  }
  try {
    bool same = true;
    for (const bool closed : {true, false}) {
      const plait::BaseMesh base = squares(9, closed);
      const char* const name = closed ? "torus" : "sheet";
      same = run<float>(base, name) && run<double>(base, name) && same;
    }
    if (!same) std::puts("the digests differ");
    return same ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
