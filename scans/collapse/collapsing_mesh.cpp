#include "collapse/collapsing_mesh.h"

#include <atomic>

PLAIT_BEGIN_PRIVATE_NAMESPACE

CollapsingMesh::CollapsingMesh(const Surface& scan)
    : faces_(scan.faces),
      across_(scan.across),
      border_(scan.positions.size(), 0),
      live_faces_(scan.faces.size()) {
  for (std::size_t code = 0; code < across_.size(); ++code) {
    if (across_[code].exists()) continue;
    FaceSide side;
    side.code = static_cast<std::uint32_t>(code);
    border_[start(side)] = border_[end(side)] = 1;
  }
}

bool CollapsingMesh::add_fan(FaceSide corner, FaceSide stop, bool at_gone, Patch& patch) const {
  for (; corner.exists() && corner != stop; corner = after(corner)) {
    if (patch.faces == kMaxFan) return false;
    const auto i = static_cast<std::size_t>(patch.faces);
    patch.corners[i] = corner;
    patch.ring[i] = at(corner.face(), corner.side() + 1);
    patch.ring[i + 1] = at(corner.face(), corner.side() + 2);
    if (at_gone) patch.at_gone |= 1u << i;
    ++patch.faces;
  }
  return true;
}

bool CollapsingMesh::has_distinct_ring(const Patch& patch) const {
  const int count = patch.ring_size();
  for (int i = 1; i < count; ++i)
    for (int j = 0; j < i; ++j)
      if (patch.ring[static_cast<std::size_t>(i)] == patch.ring[static_cast<std::size_t>(j)])
        return false;
  return true;
}

bool CollapsingMesh::gather(FaceSide side, Patch& patch) const {
  // The corners of the left face at the two ends, and those of the right face.
  FaceSide right = across(side);
  if (right.exists() && is_border(end(side))) {
    if (is_border(start(side))) return false;  // the fan's vertex would be on the border twice
    std::swap(side, right);
  }
  patch.kept = start(side);
  patch.gone = end(side);
  patch.faces = 0;
  patch.at_gone = 0;
  patch.border_edge = !right.exists();
  patch.closed = !patch.border_edge && !is_border(patch.kept);
  const FaceSide left_kept(side.face(), (side.side() + 1) % 3),
      left_gone(side.face(), (side.side() + 2) % 3);
  patch.lost[0] = left_kept;
  if (patch.border_edge) {
    patch.lost_faces = 1;
    FaceSide first = left_gone;
    for (FaceSide earlier = before(first); earlier.exists(); earlier = before(first))
      first = earlier;
    if (!add_fan(first, left_gone, true, patch)) return false;
    patch.apex[0] = patch.faces;
    if (!add_fan(after(left_kept), FaceSide(), false, patch)) return false;
    return patch.faces >= 1 && has_distinct_ring(patch);
  }
  patch.lost_faces = 2;
  const FaceSide right_kept(right.face(), (right.side() + 2) % 3),
      right_gone(right.face(), (right.side() + 1) % 3);
  patch.lost[1] = right_kept;
  if (patch.closed) {
    patch.apex[0] = 0;
    if (!add_fan(after(left_kept), right_kept, false, patch)) return false;
    patch.apex[1] = patch.faces;
    if (!add_fan(after(right_gone), left_gone, true, patch)) return false;
    return patch.faces >= 3 && has_distinct_ring(patch);
  }
  FaceSide first = right_kept;
  for (FaceSide earlier = before(first); earlier.exists(); earlier = before(first)) first = earlier;
  if (!add_fan(first, right_kept, false, patch)) return false;
  patch.apex[1] = patch.faces;
  if (!add_fan(after(right_gone), left_gone, true, patch)) return false;
  patch.apex[0] = patch.faces;
  if (!add_fan(after(left_kept), FaceSide(), false, patch)) return false;
  return patch.faces >= 1 && has_distinct_ring(patch);
}

void CollapsingMesh::remove_face(FaceSide corner_at_kept, bool left) {
  // The side between the ends of the edge goes with the face; the other two become one edge.
  const std::uint32_t base = 3 * corner_at_kept.face();
  const int corner = corner_at_kept.side();
  const FaceSide opposite_kept = across_[base + static_cast<std::uint32_t>(corner)];
  // Of the left face, the next corner is at `gone`; of the right one, the corner before.
  const FaceSide opposite_gone = across_[base + next_of(left ? corner : corner + 1)];
  if (opposite_kept.exists()) across_[opposite_kept.code] = opposite_gone;
  if (opposite_gone.exists()) across_[opposite_gone.code] = opposite_kept;
  faces_[corner_at_kept.face()] = {kNoId, kNoId, kNoId};
  std::atomic_ref(live_faces_).fetch_sub(1, std::memory_order_relaxed);
}

void CollapsingMesh::collapse(const Patch& patch) {
  for (int i = 0; i < patch.faces; ++i) {
    if (!patch.is_at_gone(i)) continue;
    const FaceSide corner = patch.corners[static_cast<std::size_t>(i)];
    faces_[corner.face()][static_cast<std::size_t>(corner.side())] = patch.kept;
  }
  for (int i = 0; i < patch.lost_faces; ++i)
    remove_face(patch.lost[static_cast<std::size_t>(i)], i == 0);
}

PLAIT_END_NAMESPACE
