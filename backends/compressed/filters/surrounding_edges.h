// backends/compressed/filters/surrounding_edges.h: finds the edges whose slots lie around the slot
// of an edge, for one edge of a block after another.
//
//            x-------x            The two faces at the edge have four more sides. Beyond each of
//           / \ own / \           them is another face, and of its two other sides the slots have
//          /   \   /   \          the vertices next to the side: the strips of the side.
//         x-----edge----x
//          \   /   \   /
//           \ /other\ /
//            x-------x
//
// From an edge to its strips it takes five look-ups in the mesh, each in another array at a place
// that the one before has found. On a large mesh each of them would wait for memory. So each edge
// is looked up in steps, some edges ahead, and each step has the processor fetch what the next step
// reads. Pinned by tests/backends/compressed/filters/hierarchy_filter_test.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "plait/detail/edge_grid.h"
#include "plait/detail/face_depths.h"
#include "plait/detail/namespace.h"
#include "plait/extend/level_geometry.h"
#include "plait/extend/topology.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Every `step`-th of the edges that have slots in a block, from the first one on.
class EdgesOfBlock {
 public:
  EdgesOfBlock(const LevelGeometry& level, std::uint64_t block, EdgeId step) noexcept
      : level_(&level),
        next_(level.first_edge(block)),
        step_(step),
        count_((level.slot_count(block) + step - 1) / step) {}

  const LevelGeometry& level() const noexcept { return *level_; }
  std::size_t count() const noexcept { return count_; }
  /// REQUIRES: it was called fewer than count() times.
  EdgeId next() noexcept {
    for (EdgeId left = is_first_ ? 1 : step_; left > 0; ++next_) left -= level_->has_slot(next_);
    is_first_ = false;
    return next_ - 1;
  }

 private:
  const LevelGeometry* level_;
  EdgeId next_, step_;
  std::size_t count_;
  bool is_first_ = true;
};

/// The edges around one edge.
struct SurroundingEdges {
  struct Strip {
    EdgeId edge = kNoId;
    bool is_own = false;  ///< whether the edge's own face is the one beyond the side
  };
  struct Side {
    EdgeId edge = kNoId;
    GridSide place = {};
    FaceSide beyond;  ///< the same side of the next face, if there is one
    /// Of the next face: first the side before this one, then the one after it.
    std::array<Strip, 2> strips;
  };

  EdgeId edge = kNoId;
  bool is_border = false;
  /// The one in whose frame the slot is, and then the other one if the edge is no border. The first
  /// is the own one, except for a half slot of the other one.
  std::array<FaceSide, 2> faces;
  std::array<Side, 4> all_sides;  ///< counterclockwise in each face

  std::span<const Side> sides() const noexcept {
    return std::span(all_sides).first(is_border ? 2 : 4);
  }
  std::span<Side> sides() noexcept { return std::span(all_sides).first(is_border ? 2 : 4); }
};

/// For one thread.
class SurroundingEdgesAhead {
 public:
  /// What is to be found beyond the sides.
  enum class Beyond : std::uint8_t { kNothing, kCorner, kStrips };
  /// How many edges ahead of the current one the look-ups of an edge are complete.
  static constexpr std::size_t kComplete = 2;

  /// `base` are the records of the base vertices, which the caller will read too. `depths` is null
  /// if all faces have all levels.
  SurroundingEdgesAhead(const Topology& mesh, const FaceDepths* depths, const EdgesOfBlock& edges,
                        const std::byte* base, std::size_t record_bytes, Beyond beyond) noexcept
      : mesh_(mesh),
        depths_(depths),
        edges_(edges),
        count_(edges.count()),
        base_(base),
        record_bytes_(record_bytes),
        beyond_(beyond) {
    for (std::size_t at = 0; at < kFirst; ++at) look_up(at);
  }

  std::size_t count() const noexcept { return count_; }
  /// Makes edge `at` of the range the current one. REQUIRES: it is the first one, or the one after
  /// the current one.
  void advance_to(std::size_t at) noexcept { look_up(at + kFirst); }
  /// REQUIRES: the edge is in the range, and is the current one or one of the next kComplete;
  /// before the first advance_to(), one of the first kComplete.
  const SurroundingEdges& operator[](std::size_t at) const noexcept { return ring_[at % kRing]; }

 private:
  static constexpr std::size_t kRing = 16, kBetween = 2, kFirst = kComplete + 4 * kBetween;
  static_assert(kFirst < kRing);

  /// Takes the first step for edge `at`, and later ones for edges before it.
  void look_up(std::size_t at) noexcept {
    if (SurroundingEdges* const found = entry(at, 0)) {
      found->edge = edges_.next();
      find_faces(*found);
    }
    if (SurroundingEdges* const found = entry(at, 1)) find_sides(*found);
    if (SurroundingEdges* const found = entry(at, 2)) find_beyond(*found);
    if (beyond_ == Beyond::kNothing) return;
    if (SurroundingEdges* const found = entry(at, 3)) find_strips(*found);
    if (beyond_ == Beyond::kCorner) return;
    if (SurroundingEdges* const found = entry(at, 4)) find_views_of_strips(*found);
  }
  SurroundingEdges* entry(std::size_t at, std::size_t step) noexcept {
    const std::size_t edge = at - step * kBetween;
    return at >= step * kBetween && edge < count_ ? &ring_[edge % kRing] : nullptr;
  }

  static void fetch(const void* address) noexcept { __builtin_prefetch(address); }
  const std::array<EdgeId, 3>& sides_of(FaceSide side) const noexcept {
    return mesh_.face_edges[side.face()];
  }

  void fetch_corner(FaceSide opposite) const noexcept {
    const auto& corners = mesh_.faces[opposite.face()];
    fetch(base_ + record_bytes_ * corners[static_cast<std::size_t>(opposite.side())]);
  }
  /// The side of the next face that has the strip.
  static int which_of(const SurroundingEdges::Side& side, int strip) noexcept {
    return (side.beyond.side() + 2 - strip) % 3;
  }

  void find_faces(SurroundingEdges& found) const noexcept {
    const Edge& edge = mesh_.edges[found.edge];
    found.is_border = edge.is_border();
    found.faces = {edge.own, edge.other};
    if (depths_ != nullptr && !depths_->own_face_has(edge, edges_.level().level()))
      std::swap(found.faces[0], found.faces[1]);
    fetch(base_ + record_bytes_ * edge.start);
    fetch(base_ + record_bytes_ * edge.end);
    for (const FaceSide side : found.faces) {
      if (!side.exists()) continue;
      fetch(&mesh_.faces[side.face()]);
      fetch(&sides_of(side));
    }
  }
  void find_sides(SurroundingEdges& found) const noexcept {
    for (std::size_t i = 0; i < found.sides().size(); ++i) {
      const bool turned = i >= 2;
      const int turn = static_cast<int>(i % 2) + 1;
      const FaceSide side = found.faces[turned ? 1 : 0];
      const auto which = static_cast<std::size_t>((side.side() + turn) % 3);
      SurroundingEdges::Side& each = found.all_sides[i];
      each.edge = sides_of(side)[which];
      each.place = {turned, turn, SlotView::kOwn};
      each.beyond = FaceSide(side.face(), static_cast<int>(which));
      fetch(&mesh_.edges[each.edge]);
      if (turn == 1) fetch_corner(side);
    }
  }
  void find_beyond(SurroundingEdges& found) const noexcept {
    for (SurroundingEdges::Side& side : found.sides()) {
      const Edge& edge = mesh_.edges[side.edge];
      if (edge.is_border()) {
        side.beyond = FaceSide();
        continue;
      }
      side.place.view = edge.own == side.beyond ? SlotView::kOwn : SlotView::kOther;
      side.beyond.code ^= edge.own.code ^ edge.other.code;
      if (beyond_ == Beyond::kCorner) fetch(&mesh_.faces[side.beyond.face()]);
      if (beyond_ == Beyond::kStrips) fetch(&sides_of(side.beyond));
    }
  }
  void find_strips(SurroundingEdges& found) const noexcept {
    for (SurroundingEdges::Side& side : found.sides()) {
      if (!side.beyond.exists()) continue;
      if (beyond_ == Beyond::kCorner) {
        fetch_corner(side.beyond);
        continue;
      }
      for (int i = 0; i < 2; ++i) {
        SurroundingEdges::Strip& strip = side.strips[static_cast<std::size_t>(i)];
        strip.edge = sides_of(side.beyond)[static_cast<std::size_t>(which_of(side, i))];
        fetch(&mesh_.edges[strip.edge]);
      }
    }
  }
  void find_views_of_strips(SurroundingEdges& found) const noexcept {
    for (SurroundingEdges::Side& side : found.sides()) {
      if (!side.beyond.exists()) continue;
      for (int i = 0; i < 2; ++i) {
        SurroundingEdges::Strip& strip = side.strips[static_cast<std::size_t>(i)];
        strip.is_own =
            mesh_.edges[strip.edge].own == FaceSide(side.beyond.face(), which_of(side, i));
      }
    }
  }

  const Topology mesh_;
  const FaceDepths* const depths_;
  EdgesOfBlock edges_;
  const std::size_t count_;
  const std::byte* const base_;
  const std::size_t record_bytes_;
  const Beyond beyond_;
  std::array<SurroundingEdges, kRing> ring_ = {};
};

PLAIT_END_NAMESPACE
