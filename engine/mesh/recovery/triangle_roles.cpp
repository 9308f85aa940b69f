#include "mesh/recovery/triangle_roles.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "io/huge_pages.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint8_t kBorder = 0x80, kMostFaces = 0x7f;
/// How far the walk over a front looks ahead, so that loads from memory overlap.
constexpr std::size_t kFrontAhead = 16;

}  // namespace

TriangleRoles::TriangleRoles(const LevelView& mesh)
    : mesh_(mesh),
      around_(huge_vector<std::uint8_t>(mesh.vertex_count())),
      faces_(huge_vector<std::uint8_t>(mesh.face_count(), kUnknown)) {
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner) {
      std::uint8_t& around = around_[mesh.vertex({face, corner})];
      if ((around & kMostFaces) < kMostFaces) ++around;
      if (mesh.twin({face, corner}).exists()) continue;
      for (int turn = 1; turn <= 2; ++turn)
        around_[mesh.vertex(turned({face, corner}, turn))] |= kBorder;
    }
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      if (may_be_new(mesh.vertex({face, corner})))
        faces_[face] |= static_cast<std::uint8_t>(1 << (kFirstMayBeNew + corner));
}

/// A new vertex is the middle of an edge: it has three triangles on each side of the edge.
bool TriangleRoles::may_be_new(VertexId vertex) const {
  return around_[vertex] == 6 || around_[vertex] == (3 | kBorder);
}

bool TriangleRoles::fail(VertexId vertex, const char* reason) {
  failure_ = {vertex, 0, (around_[vertex] & kBorder) != 0, reason};
  return false;
}

RecoveryFailure TriangleRoles::failure() const {
  RecoveryFailure failure = failure_;
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      failure.faces += mesh_.vertex({face, corner}) == failure.vertex;
  return failure;
}

bool TriangleRoles::set(FaceId face, Role role) {
  unsigned must_be_new = kAllMayBeNew;
  if (role != kMiddle) must_be_new &= ~(1u << (kFirstMayBeNew + role - kFirstCorner));
  if (const unsigned wrong = must_be_new & ~unsigned{faces_[face]}; wrong != 0) {
    const VertexId vertex = mesh_.vertex({face, std::countr_zero(wrong) - kFirstMayBeNew});
    return fail(vertex, (around_[vertex] & kBorder) != 0
                            ? "it would be a new vertex, which has three faces on a border"
                            : "it would be a new vertex, which has six faces");
  }
  put(face, role);
  next_front_.push_back(face);
  if (reached_) reached_->push_back(face);
  return true;
}

/// Gives roles to the component of a face, front after front: the faces of a front are known long
/// before their neighbours are needed.
bool TriangleRoles::spread(FaceId first, Role role) {
  next_front_.clear();
  if (!set(first, role)) return false;
  while (!next_front_.empty()) {
    std::swap(front_, next_front_);
    next_front_.clear();
    for (std::size_t at = 0; at < front_.size(); ++at) {
      if (at + kFrontAhead < front_.size()) mesh_.prefetch_twins(front_[at + kFrontAhead]);
      if (!spread_from(front_[at])) return false;
    }
  }
  return true;
}

bool TriangleRoles::spread_from(FaceId face) {
  const int kept = is_middle(face) ? -1 : role(face) - kFirstCorner;
  for (int side = 0; side < 3; ++side) {
    const FaceSide across = mesh_.twin({face, side});
    const bool joins_new = kept < 0 || kept == side;
    if (!across.exists()) {
      if (joins_new)
        return fail(mesh_.vertex({face, (side + 1) % 3}),
                    "it and its neighbour on the border would both be new");
      continue;
    }
    // The edge runs from corner side + 1 to side + 2 here, and the other way across it.
    const int corner = kept < 0                 ? across.side()
                       : kept == side           ? -1
                       : kept == (side + 1) % 3 ? (across.side() + 2) % 3
                                                : (across.side() + 1) % 3;
    const Role wanted = corner < 0 ? kMiddle : static_cast<Role>(kFirstCorner + corner);
    const Role found = role(across.face());
    if (found == wanted) continue;
    if (found != kUnknown)
      return fail(mesh_.vertex({face, (side + 1) % 3}),
                  "on one way it would be new, and on another one it would be kept");
    if (!set(across.face(), wanted)) return false;
  }
  return true;
}

bool TriangleRoles::find() {
  for (FaceId face = 0; face < mesh_.face_count(); ++face) {
    const unsigned kept = kAllMayBeNew & ~unsigned{faces_[face]};
    if (kept == 0 || role(face) != kUnknown) continue;
    const int corner = std::countr_zero(kept) - kFirstMayBeNew;
    if (!spread(face, static_cast<Role>(kFirstCorner + corner))) return false;
  }
  const auto is_unknown = [](std::uint8_t face) { return (face & kRoleBits) == kUnknown; };
  return std::ranges::none_of(faces_, is_unknown) || find_in_regular_components();
}

/// The smallest vertex that is kept if the face has this role; nothing if it cannot have it. The
/// component has no roles afterwards.
std::optional<VertexId> TriangleRoles::smallest_kept(FaceId first, Role role) {
  std::vector<FaceId> reached;
  reached_ = &reached;
  const bool possible = spread(first, role);
  reached_ = nullptr;
  std::optional<VertexId> smallest;
  for (const FaceId face : reached) {
    if (possible && !is_middle(face))
      smallest = std::min(smallest.value_or(kNoId), mesh_.vertex(kept_corner(face)));
    put(face, kUnknown);
  }
  return smallest;
}

/// Components whose vertices may all be new are tori and rings. The answers differ by a shift of
/// the mesh onto itself, so they are equally deep: the one that keeps the smallest vertex is taken.
bool TriangleRoles::find_in_regular_components() {
  std::vector<FaceSide> corner_of(mesh_.vertex_count());
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    if (role(face) == kUnknown)
      for (int corner = 0; corner < 3; ++corner)
        corner_of[mesh_.vertex({face, corner})] = {face, corner};
  for (VertexId vertex = 0; vertex < mesh_.vertex_count(); ++vertex)
    if (corner_of[vertex].exists() && role(corner_of[vertex].face()) == kUnknown &&
        !choose(vertex, corner_of[vertex]))
      return false;
  return true;
}

bool TriangleRoles::choose(VertexId smallest, FaceSide corner) {
  VertexId best = kNoId;
  Role chosen = kUnknown;
  for (int turn = 0; turn <= 3 && best != smallest; ++turn) {
    const Role tried =
        turn == 3 ? kMiddle : static_cast<Role>(kFirstCorner + turned(corner, turn).side());
    const VertexId kept = smallest_kept(corner.face(), tried).value_or(kNoId);
    if (kept >= best) continue;
    best = kept;
    chosen = tried;
  }
  if (chosen == kUnknown) return false;
  had_choice_ = true;
  return spread(corner.face(), chosen);
}

PLAIT_END_NAMESPACE
