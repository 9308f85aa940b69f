#include "collapse/collapsing_mesh.h"

#include <atomic>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE

CollapsingMesh::CollapsingMesh(const Surface& scan, const Creases& creases,
                               std::vector<std::uint8_t> corners)
    : faces_(scan.faces),
      across_(scan.across),
      lines_(scan.positions.size(), 0),
      corners_(std::move(corners)),
      creases_(creases.sides),
      live_faces_(scan.faces.size()) {
  corners_.resize(scan.positions.size(), 0);
  for (std::size_t vertex = 0; vertex < creases.corners.size(); ++vertex)
    corners_[vertex] |= creases.corners[vertex];
  for (std::size_t code = 0; code < across_.size(); ++code) {
    FaceSide side;
    side.code = static_cast<std::uint32_t>(code);
    const std::uint8_t line = !across_[code].exists() ? kBorder : is_crease(side) ? kCrease : 0;
    lines_[start(side)] |= line;
    lines_[end(side)] |= line;
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

bool CollapsingMesh::choose_kept(FaceSide& side) const {
  const FaceSide right = across(side);
  // A border edge can keep either end (Anchor).
  if (!right.exists()) return !is_corner(start(side)) || !is_corner(end(side));
  // Otherwise the fan's vertex would be on a border or a crease twice, or a corner would be gone.
  const auto has_to_stay = [&](VertexId vertex) {
    return is_crease(side) ? is_corner(vertex) : lines_[vertex] != 0;
  };
  if (!has_to_stay(end(side))) return true;
  if (has_to_stay(start(side))) return false;
  side = right;
  return true;
}

bool CollapsingMesh::find_creases(Patch& patch) const {
  patch.crease_at_gone = patch.crease_at_kept = -1;
  if (!patch.crease_edge) return true;
  for (int i = 0; i < patch.faces; ++i) {
    const FaceSide corner = patch.corners[static_cast<std::size_t>(i)];
    int& place = patch.is_at_gone(i) ? patch.crease_at_gone : patch.crease_at_kept;
    if (is_crease(FaceSide(corner.face(), (corner.side() + 2) % 3))) place = i;
    if (is_crease(FaceSide(corner.face(), (corner.side() + 1) % 3))) place = patch.next(i);
  }
  if (patch.kept_stays) patch.crease_at_kept = -1;
  // A crease that goes on to an apex would become one with another edge.
  for (const int apex : patch.apex)
    if (apex == patch.crease_at_gone || apex == patch.crease_at_kept) return false;
  return patch.crease_at_gone >= 0 && (patch.kept_stays || patch.crease_at_kept >= 0);
}

bool CollapsingMesh::gather(FaceSide side, Patch& patch) const {
  if (!choose_kept(side)) return false;
  patch.crease_edge = across(side).exists() && is_crease(side);
  patch.border_edge = !across(side).exists();
  patch.kept = start(side);
  patch.gone = end(side);
  patch.closed = !patch.border_edge && !is_border(patch.kept);
  patch.kept_stays = patch.crease_edge   ? is_corner(patch.kept)
                     : patch.border_edge ? false
                                         : lines_[patch.kept] != 0;
  return gather_ring(side, patch) && find_creases(patch);
}

bool CollapsingMesh::gather_ring(FaceSide side, Patch& patch) const {
  // The corners of the left face at the two ends, and those of the right face.
  const FaceSide right = across(side);
  patch.faces = 0;
  patch.at_gone = 0;
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
  if (!creases_.empty()) {
    const bool crease = (opposite_kept.exists() && is_crease(opposite_kept)) ||
                        (opposite_gone.exists() && is_crease(opposite_gone));
    for (const FaceSide side : {opposite_kept, opposite_gone})
      if (side.exists() && crease) creases_[side.code] = 1;
  }
  faces_[corner_at_kept.face()] = {kNoId, kNoId, kNoId};
  std::atomic_ref(live_faces_).fetch_sub(1, std::memory_order_relaxed);
}

void CollapsingMesh::collapse(const Patch& patch) {
  for (int i = 0; i < patch.faces; ++i) {
    if (!patch.is_at_gone(i)) continue;
    const FaceSide corner = patch.corners[static_cast<std::size_t>(i)];
    faces_[corner.face()][static_cast<std::size_t>(corner.side())] = patch.kept;
  }
  corners_[patch.kept] |= corners_[patch.gone];  // of a border edge, either end can be one
  for (int i = 0; i < patch.lost_faces; ++i)
    remove_face(patch.lost[static_cast<std::size_t>(i)], i == 0);
}

PLAIT_END_NAMESPACE
