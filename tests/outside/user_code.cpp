// Sources of a program of somebody else's that must not be warned of anything in plait's headers,
// whatever warnings it asks for: every options struct with one member named, and the templates
// used.
#include <memory>

#include "plait/attribute.h"
#include "plait/digest.h"
#include "plait/extend/block_makers.h"
#include "plait/extend/fused.h"
#include "plait/extend/in_core_mesh.h"
#include "plait/extend/patch.h"
#include "plait/extend/rule_patches.h"
#include "plait/extend/sweep.h"
#include "plait/extend/vertex_numbering.h"
#include "plait/layout.h"
#include "plait/own_rule.h"
#include "plait/registry.h"
#include "plait/store.h"
#include "plait/subdivide.h"
#include "plait/verify.h"
#include "plait/visit_vertices.h"

using Position = plait::Vector3<float>;

struct Rule {
  template <class V>
  V odd(V a, V b, V, V) const {
    return 0.5 * (a + b);
  }
  template <class V>
  V odd_border(V a, V b) const {
    return 0.5 * (a + b);
  }
};

std::uint64_t use_everything(const plait::BaseMesh& mesh) {
  plait::BackendRegistry backends = plait::default_backends();
  backends.add({.name = "other"});
  plait::Store store = plait::Store::create({}, plait::lay_out(mesh, plait::LayoutKind::kHilbert),
                                            {.backend = "memory"}, backends);
  plait::add_base_positions(store);
  store.add_attribute({.name = "colour"});
  plait::subdivide(store, {.levels = 2});
  const plait::OneRingScheme scheme = plait::own_scheme("own", Rule{});
  plait::subdivide(store, {.scheme = scheme, .levels = 3});
  plait::sweep(store, {.accesses = {{.attribute = 0}}}, {.threads = 2});
  plait::fused(store, {.name = "nothing"}, {.threads = 2});

  store.add_attribute(plait::schema_of<Position>("smooth"), 3);
  plait::visit_vertices(
      store, {.threads = 2},
      std::tuple{plait::rings_of<Position>("position"), plait::overwrites<Position>("smooth")},
      [](const plait::VertexRun& run, const plait::VertexRings<Position>& from,
         std::span<Position> to) {
        for (std::size_t i = 0; i < run.count; ++i) to[i] = from.neighbour(i, from.valence() - 1);
      });
  plait::visit_needs(store, {.level = 2}, std::tuple{plait::updates<Position>("smooth")});

  plait::StorePatches<Position> patches(store, store.attribute("position"), 1 << 20);
  plait::InCoreMesh<Position> arrays(mesh, 2);
  plait::refine_patches(patches, 2, plait::loop_scheme().rule<float>());
  plait::refine_patches(arrays, 2, plait::loop_scheme().rule<float>());
  plait::RingTable<Position> rings(mesh.edge_count());
  rings.set_from_base(mesh.topology(), arrays.base_records());

  plait::Store opened = plait::Store::open("some.plait", {.writable = true}, backends);
  plait::repair("some.plait", {.dry_run = true}, backends,
                plait::subdivision_block_makers({scheme}));
  return plait::digest(opened, {.level = 1}).low;
}
