#include "mesh/recovery/triangle_roles.h"

#include <algorithm>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint8_t kBorder = 0x80, kMostFaces = 0x7f;

}  // namespace

TriangleRoles::TriangleRoles(const LevelView& mesh)
    : mesh_(mesh), around_(mesh.vertex_count(), 0), roles_(mesh.face_count(), kUnknown) {
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner) {
      std::uint8_t& around = around_[mesh.vertex({face, corner})];
      if ((around & kMostFaces) < kMostFaces) ++around;
      if (mesh.twin({face, corner}).exists()) continue;
      for (int turn = 1; turn <= 2; ++turn)
        around_[mesh.vertex(turned({face, corner}, turn))] |= kBorder;
    }
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
  for (int corner = 0; corner < 3; ++corner)
    if (role != kFirstCorner + corner)
      if (const VertexId vertex = mesh_.vertex({face, corner}); !may_be_new(vertex))
        return fail(vertex, (around_[vertex] & kBorder) != 0
                                ? "it would be a new vertex, which has three faces on a border"
                                : "it would be a new vertex, which has six faces");
  roles_[face] = role;
  to_do_.push_back(face);
  if (reached_) reached_->push_back(face);
  return true;
}

/// Gives roles to the component of a face.
bool TriangleRoles::spread(FaceId first, Role role) {
  to_do_.clear();
  if (!set(first, role)) return false;
  while (!to_do_.empty()) {
    const FaceId face = to_do_.back();
    to_do_.pop_back();
    const int kept = roles_[face] == kMiddle ? -1 : roles_[face] - kFirstCorner;
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
      Role& found = roles_[across.face()];
      if (found == wanted) continue;
      if (found != kUnknown)
        return fail(mesh_.vertex({face, (side + 1) % 3}),
                    "on one way it would be new, and on another one it would be kept");
      if (!set(across.face(), wanted)) return false;
    }
  }
  return true;
}

bool TriangleRoles::find() {
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    for (int corner = 0; corner < 3 && roles_[face] == kUnknown; ++corner)
      if (!may_be_new(mesh_.vertex({face, corner})) &&
          !spread(face, static_cast<Role>(kFirstCorner + corner)))
        return false;
  return std::ranges::find(roles_, kUnknown) == roles_.end() || find_in_regular_components();
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
    roles_[face] = kUnknown;
  }
  return smallest;
}

/// Components whose vertices may all be new are tori and rings. The answers differ by a shift of
/// the mesh onto itself, so they are equally deep: the one that keeps the smallest vertex is taken.
bool TriangleRoles::find_in_regular_components() {
  std::vector<FaceSide> corner_of(mesh_.vertex_count());
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    if (roles_[face] == kUnknown)
      for (int corner = 0; corner < 3; ++corner)
        corner_of[mesh_.vertex({face, corner})] = {face, corner};
  for (VertexId vertex = 0; vertex < mesh_.vertex_count(); ++vertex)
    if (corner_of[vertex].exists() && roles_[corner_of[vertex].face()] == kUnknown &&
        !choose(vertex, corner_of[vertex]))
      return false;
  return true;
}

bool TriangleRoles::choose(VertexId smallest, FaceSide corner) {
  VertexId best = kNoId;
  Role role = kUnknown;
  for (int turn = 0; turn <= 3 && best != smallest; ++turn) {
    const Role tried =
        turn == 3 ? kMiddle : static_cast<Role>(kFirstCorner + turned(corner, turn).side());
    const VertexId kept = smallest_kept(corner.face(), tried).value_or(kNoId);
    if (kept >= best) continue;
    best = kept;
    role = tried;
  }
  if (role == kUnknown) return false;
  had_choice_ = true;
  return spread(corner.face(), role);
}

PLAIT_END_NAMESPACE
