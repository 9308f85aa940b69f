#include "layout/vertex_fan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mesh/connectivity.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

FaceSide leaving_side(FaceSide corner) { return {corner.face(), (corner.side() + 2) % 3}; }
FaceSide coming_side(FaceSide corner) { return {corner.face(), (corner.side() + 1) % 3}; }

FaceSide side_of(std::uint64_t key) { return from_code(static_cast<std::uint32_t>(key)); }

}  // namespace

void VertexFan::find(std::span<const CornerAtVertex> corners) {
  sides_.clear();
  twins_.assign(corners.size(), kNoId);
  follows_.assign(corners.size(), kNoId);
  is_on_border_ = false;
  for (std::uint32_t at = 0; at < corners.size(); ++at) {
    const FaceSide corner = from_code(corners[at].code);
    sides_.push_back({std::uint64_t{corners[at].next} << 32 | leaving_side(corner).code, at, true});
    sides_.push_back(
        {std::uint64_t{corners[at].before} << 32 | coming_side(corner).code, at, false});
  }
  std::ranges::sort(sides_, {}, &Side::key);
  for (std::size_t first = 0; first < sides_.size();) {
    std::size_t after = first + 1;
    while (after < sides_.size() && sides_[after].key >> 32 == sides_[first].key >> 32) ++after;
    match(corners.front().vertex, std::span(sides_).subspan(first, after - first), corners);
    first = after;
  }
  find_first(corners);
}

/// Both vertices of an edge see the same sides. The lower one reports what is wrong.
void VertexFan::match(VertexId vertex, std::span<const Side> same_edge,
                      std::span<const CornerAtVertex> corners) {
  const auto other = static_cast<VertexId>(same_edge[0].key >> 32);
  const bool reports = vertex < other;
  if (same_edge.size() > 2) {
    if (!reports) return;
    std::array<std::uint64_t, 3> faces;
    for (std::size_t at = 0; at < 3; ++at) faces[at] = side_of(same_edge[at].key).face();
    throw too_many_faces_at_edge(source_, vertex, other, faces, same_edge.size());
  }
  const Side& one = same_edge[0];
  if (same_edge.size() == 1) {
    if (one.leaves) ++border_edges_;
    is_on_border_ = true;
    return;
  }
  const Side& two = same_edge[1];
  if (one.leaves != two.leaves) {
    const Side& leaves = one.leaves ? one : two;
    const Side& comes = one.leaves ? two : one;
    twins_[leaves.corner] = side_of(comes.key).code;
    follows_[comes.corner] = leaves.corner;
    return;
  }
  const FaceId first_face = side_of(one.key).face(), second_face = side_of(two.key).face();
  const auto opposite = [&](const Side& side) {
    return side.leaves ? corners[side.corner].before : corners[side.corner].next;
  };
  if (reports && opposite(one) == opposite(two))
    throw copied_face(source_, second_face, first_face);
  if (not_oriented_ || !reports) return;
  not_oriented_ = Error(
      ErrorCode::kNotSupported,
      fmt::format("{}: edge {}-{}: expected faces {} and {} to have one orientation, found two: "
                  "they are turned in memory only, so write the file anew with faces of one "
                  "orientation",
                  source_, vertex, other, first_face, second_face));
}

void VertexFan::find_first(std::span<const CornerAtVertex> corners) {
  std::uint32_t smallest = kNoId;
  for (std::size_t at = 0; at < corners.size(); ++at) {
    const std::uint32_t rank = fan_rank(twins_[at] == kNoId, corners[at].next);
    if (rank >= smallest) continue;
    smallest = rank;
    first_ = at;
  }
  if (not_oriented_ || not_one_fan_) return;
  std::size_t reached = 0;
  std::uint32_t at = static_cast<std::uint32_t>(first_);
  do {
    ++reached;
    at = follows_[at];
  } while (at != kNoId && at != first_);
  if (reached != corners.size())
    not_one_fan_ = more_than_one_fan(source_, corners.front().vertex, corners.size(), reached,
                                     from_code(corners[first_].code).face());
}

void VertexFan::check_all() const {
  if (not_oriented_) throw Error(*not_oriented_);
  if (not_one_fan_) throw Error(*not_one_fan_);
}

PLAIT_END_NAMESPACE
