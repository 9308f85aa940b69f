#include "collapse/collapser.h"

#include <algorithm>
#include <cmath>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Faces or edges between two calls of `tell`.
constexpr std::uint64_t kBetweenTells = 4096;

}  // namespace

void Collapser::shape_patch(const Patch& patch, PatchShape& shape) const {
  for (int i = 0; i < patch.ring_size(); ++i)
    shape.ring[static_cast<std::size_t>(i)] =
        state_.positions[patch.ring[static_cast<std::size_t>(i)]];
  shape.kept = state_.positions[patch.kept];
  shape.gone = state_.positions[patch.gone];
  if (patch.kept_stays) {
    shape.now = shape.kept;
    return;
  }
  shape.anchor = Anchor::kNone;
  if (const bool at_kept = state_.mesh.is_corner(patch.kept);
      patch.border_edge && (at_kept || state_.mesh.is_corner(patch.gone))) {
    shape.anchor = at_kept ? Anchor::kKept : Anchor::kGone;
    shape.now = at_kept ? shape.kept : shape.gone;
    return;
  }
  const Point middle = 0.5 * (shape.kept + shape.gone);
  shape.now = (state_.quadrics[patch.kept] + state_.quadrics[patch.gone]).minimum(middle);
}

bool Collapser::fan_fits(const Patch& patch, const PatchShape& shape) {
  fan_area_ = 0;
  fan_quality_ = 1;
  fan_normal_ = {0, 0, 0};
  std::array<Point, kMaxFan> normals;
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    const Point a = shape.ring[at], b = shape.ring[after];
    const Point old = patch.is_at_gone(i) ? shape.gone : shape.kept;
    const Point before = area_vector(old, a, b), now = area_vector(shape.now, a, b);
    const double before_area = length(before), now_area = length(now);
    if (dot(before, now) < limits_.least_turn * before_area * now_area) return false;
    const double side = squared_length(b - a);
    const double quality = triangle_quality(
        now_area, side + squared_length(a - shape.now) + squared_length(b - shape.now));
    if (quality < limits_.least_quality) {
      const double earlier =
          triangle_quality(before_area, side + squared_length(a - old) + squared_length(b - old));
      if (!(quality > earlier)) return false;
    }
    fan_quality_ = std::min(fan_quality_, quality);
    normals[at] = now;
    face_areas_[at] = now_area / 2;
    fan_area_ += now_area / 2;
    fan_normal_ = fan_normal_ + now;
  }
  // The faces around a vertex of a crease are no cone.
  if (state_.mesh.is_on_crease(patch.kept)) return fan_quality_ > 0;
  const double normal_length = length(fan_normal_);
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (dot(normals[at], fan_normal_) < limits_.least_cone * 2 * face_areas_[at] * normal_length)
      return false;
  }
  return fan_quality_ > 0;
}

void Collapser::offer(FaceSide edge) {
  if (!is_inside(edge)) return;
  if (!state_.mesh.gather(edge, patch_)) {
    ++refused_.by_topology;
    return;
  }
  shape_patch(patch_, shape_);
  if (!fan_fits(patch_, shape_)) {
    ++refused_.by_shape;
    return;
  }
  double carried = 0;
  for (int i = 0; i < patch_.faces; ++i)
    carried += double{state_.carried[patch_.corners[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch_.lost_faces; ++i)
    carried += double{state_.carried[patch_.lost[static_cast<std::size_t>(i)].face()]};
  const double distance =
      std::max(0.0, (state_.quadrics[patch_.kept] + state_.quadrics[patch_.gone]).at(shape_.now));
  const double stretch = carried / fan_area_;
  const double cost = distance * stretch * stretch / std::sqrt(fan_quality_);
  queue_.push_back(
      {static_cast<float>(cost), edge, state_.stamps[patch_.kept] + state_.stamps[patch_.gone]});
  state_.waits[edge.code] = 1;
}

void Collapser::push(FaceSide edge) {
  const std::size_t size = queue_.size();
  offer(edge);
  if (queue_.size() > size) std::push_heap(queue_.begin(), queue_.end());
}

void Collapser::fill_queue(std::span<const FaceId> faces, const std::function<void()>& tell) {
  queue_.clear();
  refused_ = {};
  std::size_t seen = 0;
  for (const FaceId face : faces) {
    if (++seen % kBetweenTells == 0 && tell) tell();
    if (!state_.mesh.lives(face)) continue;
    for (int side = 0; side < 3; ++side) {
      const FaceSide edge(face, side), beyond = state_.mesh.across(edge);
      state_.waits[edge.code] = 0;
      if (!beyond.exists() || edge.code < beyond.code) offer(edge);
    }
  }
  std::make_heap(queue_.begin(), queue_.end());
}

void Collapser::share_area(const Patch& patch) {
  double carried = 0;
  for (int i = 0; i < patch.lost_faces; ++i)
    carried += double{state_.carried[patch.lost[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch.faces; ++i)
    carried += double{state_.carried[patch.corners[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i);
    state_.carried[patch.corners[at].face()] =
        static_cast<float>(carried * face_areas_[at] / fan_area_);
  }
}

std::uint64_t Collapser::try_collapse(FaceSide edge) {
  if (!state_.mesh.gather(edge, patch_)) return 0;
  shape_patch(patch_, shape_);
  if (!fan_fits(patch_, shape_)) return 0;
  const auto plane = lay_out(patch_, shape_);
  if (!plane) return 0;
  state_.history.add(patch_, *plane, room_);
  share_area(patch_);
  state_.mesh.collapse(patch_);
  state_.positions[patch_.kept] = shape_.now;
  state_.quadrics[patch_.kept] = state_.quadrics[patch_.kept] + state_.quadrics[patch_.gone];
  ++state_.stamps[patch_.kept];

  const Patch done = patch_;  // offer() gathers others
  for (int i = 0; i < done.faces; ++i) {
    const FaceSide corner = done.corners[static_cast<std::size_t>(i)];
    for (const bool last : {false, true}) {
      if (last && (done.closed || i + 1 < done.faces)) continue;
      const FaceSide spoke(corner.face(), (corner.side() + (last ? 1 : 2)) % 3);
      const FaceSide beyond = state_.mesh.across(spoke);
      if (state_.waits[spoke.code] == 0 && (!beyond.exists() || state_.waits[beyond.code] == 0)) {
        push(spoke);
      } else if (beyond.exists() && state_.waits[spoke.code] != 0) {
        state_.waits[beyond.code] = 0;  // two edges became this one
      }
    }
  }
  return static_cast<std::uint64_t>(done.lost_faces);
}

std::uint64_t Collapser::collapse(std::span<const FaceId> faces, const ShapeLimits& limits,
                                  std::uint64_t count, const std::function<void()>& tell) {
  limits_ = limits;
  fill_queue(faces, tell);
  std::uint64_t gone = 0, pops = 0;
  while (gone < count && !queue_.empty()) {
    if (++pops % kBetweenTells == 0 && tell) tell();
    std::pop_heap(queue_.begin(), queue_.end());
    const Candidate next = queue_.back();
    queue_.pop_back();
    if (state_.waits[next.edge.code] == 0 || !state_.mesh.lives(next.edge.face())) continue;
    state_.waits[next.edge.code] = 0;
    const VertexId start = state_.mesh.start(next.edge), end = state_.mesh.end(next.edge);
    // Costs mostly grow, so an edge that is not the cheapest any more waits with its old cost.
    if (state_.stamps[start] + state_.stamps[end] != next.stamp)
      push(next.edge);
    else
      gone += try_collapse(next.edge);
  }
  return gone;
}

CollapseRefusals Collapser::refusals(std::span<const FaceId> faces, const ShapeLimits& limits,
                                     const std::function<void()>& tell) {
  limits_ = limits;
  fill_queue(faces, tell);
  return refused_;
}

PLAIT_END_NAMESPACE
