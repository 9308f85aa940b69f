#include "paper/paper_way.h"

#include "plait/extend/edge_index.h"
#include "plait/extend/rule_patches.h"
#include "plait/extend/store_access.h"
#include "plait/subdivide.h"

namespace plait::paper {
namespace {

using Record = Vector3<float>;
using Patches = StorePatches<Record>;

/// A triangle of the grid of `level`: corners (i, j), (i + 1, j), (i, j + 1), or, upside down,
/// (i + 1, j + 1), (i, j + 1), (i + 1, j).
struct Triangle {
  int level;
  std::int64_t i, j;
  bool upside_down;
};

/// Each edge of a grid belongs to exactly one triangle that is not upside down, and its middle is a
/// vertex of the next level.
template <class Visit>
void walk(const Triangle& cell, int first, int last, const Visit& visit) {
  const int next = cell.level + 1;
  if (next > last) return;
  const std::int64_t i = 2 * cell.i, j = 2 * cell.j;
  if (!cell.upside_down && next >= first) {
    visit(next, i + 1, j);
    visit(next, i + 1, j + 1);
    visit(next, i, j + 1);
  }
  const bool down = cell.upside_down;
  const std::int64_t shift = down ? 1 : 0;
  walk(Triangle{next, i + shift, j + shift, false}, first, last, visit);
  walk(Triangle{next, i + 1, j, down}, first, last, visit);
  walk(Triangle{next, i, j + 1, down}, first, last, visit);
  walk(Triangle{next, i + shift, j + shift, true}, first, last, visit);
}

/// For the vertices of levels `first` to `last` that each patch computes, calls visit(patch, side,
/// row, column, born, on_border), and then done(patch).
template <class Visit, class Done>
void walk_patches(Patches& mesh, int first, int last, const Visit& visit, const Done& done) {
  for (FaceId face = 0; face < mesh.topology().faces.size(); ++face) {
    const auto patch = mesh.patch(face);
    walk(Triangle{0, 0, 0, false}, first, last, [&](int born, std::int64_t i, std::int64_t j) {
      const SideIndex at = to_side(born, i, j);
      const bool on_side = at.row + at.column == slot_side(born) - 1;
      if (on_side && !patch.owns(at.side)) return;
      const bool border = on_side && patch.is_border(at.side);
      if (at.side == 0)
        visit(patch, PatchSide<0>(), at.row, at.column, born, border);
      else if (at.side == 1)
        visit(patch, PatchSide<1>(), at.row, at.column, born, border);
      else
        visit(patch, PatchSide<2>(), at.row, at.column, born, border);
    });
    done(patch);
  }
}

void odd_pass(Patches& mesh, int level, const OneRing<float>& rule, RingTable<Record>& rings) {
  mesh.activate(level, level, level);
  walk_patches(
      mesh, level, level,
      [&](const auto& patch, auto side, std::int64_t row, std::int64_t column, int, bool border) {
        const PatchFrame frame(patch, side, level, row, column, level);
        const Record& a = frame.coarse_at(-1, 1);
        const Record& b = frame.coarse_at(1, -1);
        frame.at(0, 0) = border ? rule.odd_border(a, b)
                                : rule.odd(a, b, frame.coarse_at(-1, -1), frame.coarse_at(1, 1));
      },
      [&](const auto& patch) { collect_rings(patch, mesh.topology(), level, rings); });
}

void even_pass(Patches& mesh, int level, const OneRing<float>& rule) {
  mesh.activate(level, 1, level - 1);
  walk_patches(
      mesh, 1, level - 1,
      [&](const auto& patch, auto side, std::int64_t row, std::int64_t column, int born,
          bool border) {
        const PatchFrame frame(patch, side, born, row, column, level);
        Record& v = frame.at(0, 0);
        v = border ? rule.even_border(v, frame.at(-1, 1), frame.at(1, -1))
                   : rule.even(v, ring_sum(frame.at(1, 0), frame.at(0, 1), frame.at(-1, 1),
                                           frame.at(-1, 0), frame.at(0, -1), frame.at(1, -1)));
      },
      [](const auto&) {});
}

/// What makes the normals at the end.
SubdivideOptions transparent(int levels) {
  return {.executor = ExecutorKind::kTransparent, .levels = levels, .normals = true};
}

}  // namespace

void walk_patch(int first, int last,
                const std::function<void(int, std::int64_t, std::int64_t)>& visit) {
  walk(Triangle{0, 0, 0, false}, first, last, visit);
}

std::uint64_t circular_buffer_bytes(std::uint64_t loop_span, int levels) {
  return 2 * window_bytes(loop_span, levels, sizeof(Record));
}

std::uint64_t paper_way_bytes(Store& store, int levels) {
  return plan_subdivision(store, transparent(levels)).needs().frames;
}

void make_in_paper_way(Store& store, int levels) {
  const AttributeId position = store.attribute("position");
  const OneRing<float>& rule = loop_scheme().rule<float>();
  RingTable<Record> rings(store.base().edge_count());
  for (int level = 1; level <= levels; ++level) {
    store.add_level(position);
    Patches mesh(store, position, StoreAccess::pager(store).budget_bytes() / 2);
    odd_pass(mesh, level, rule, rings);
    if (level > 1) even_pass(mesh, level, rule);
    move_base_vertices(store.base().topology(), rings, rule, store.base_records<Record>(position));
  }
  subdivide(store, transparent(levels));
}

}  // namespace plait::paper
