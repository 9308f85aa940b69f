#include "mesh/recovery/triangle_roles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "base/interruption.h"
#include "io/huge_pages.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::uint8_t kBorder = 0x80, kMostFaces = 0x7f;
/// How far the walk over a front looks ahead, so that loads from memory overlap.
constexpr std::size_t kFrontAhead = 16;

/// The role of the face across a side of a face with a role: [role][side][side of the face across].
constexpr auto kRolesAcross = [] {
  std::array<std::array<std::array<TriangleRoles::Role, 3>, 3>, 4> roles{};
  for (std::size_t kept = 0; kept < 3; ++kept)
    for (std::size_t side = 0; side < 3; ++side)
      for (std::size_t across = 0; across < 3; ++across) {
        // The edge runs from corner side + 1 to side + 2 here, and the other way across it.
        const std::size_t corner = kept == (side + 1) % 3 ? across + 2 : across + 1;
        roles[TriangleRoles::kFirstCorner + kept][side][across] =
            kept == side
                ? TriangleRoles::kMiddle
                : static_cast<TriangleRoles::Role>(TriangleRoles::kFirstCorner + corner % 3);
        roles[TriangleRoles::kMiddle][side][across] =
            static_cast<TriangleRoles::Role>(TriangleRoles::kFirstCorner + across);
      }
  return roles;
}();

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

bool TriangleRoles::fail(FaceSide at_vertex, const char* reason) {
  failure_ = {mesh_.file_vertex(at_vertex), 0, (around_[mesh_.vertex(at_vertex)] & kBorder) != 0,
              reason};
  return false;
}

RecoveryFailure TriangleRoles::failure() const {
  RecoveryFailure failure = failure_;
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    for (int corner = 0; corner < 3; ++corner)
      failure.faces += mesh_.file_vertex({face, corner}) == failure.vertex;
  return failure;
}

/// Gives a role to a face. Without branches that depend on which corner of a face is the first.
bool TriangleRoles::set(FaceId face, Role role) {
  const std::uint8_t state = faces_[face];
  // All vertices but the kept one; kMiddle keeps none.
  const unsigned must_be_new = kAllMayBeNew & ~(1u << role << (kFirstMayBeNew - kFirstCorner));
  if (const unsigned wrong = must_be_new & ~unsigned{state}; wrong != 0) {
    const FaceSide at{face, std::countr_zero(wrong) - kFirstMayBeNew};
    return fail(at, (around_[mesh_.vertex(at)] & kBorder) != 0
                        ? "it would be a new vertex, which has three faces on a border"
                        : "it would be a new vertex, which has six faces");
  }
  faces_[face] = static_cast<std::uint8_t>((state & kAllMayBeNew) | role);
  next_front_[next_size_] = face;
  next_size_ += (state & kRoleBits) == kUnknown ? 1 : 0;
  return true;
}

/// Gives roles to the component of a face, front after front: the faces of a front are known long
/// before their neighbours are needed.
bool TriangleRoles::spread(FaceId first, Role role) {
  next_front_.resize(std::max<std::size_t>(next_front_.size(), 1));
  next_size_ = 0;
  bool possible = set(first, role);
  std::uint64_t turn = 0;
  while (possible && next_size_ > 0) {
    std::swap(front_, next_front_);
    const std::span<const FaceId> front = std::span(front_).first(next_size_);
    if (reached_) reached_->insert(reached_->end(), front.begin(), front.end());
    next_front_.resize(std::max(next_front_.size(), 3 * front.size() + 1));
    next_size_ = 0;
    for (std::size_t at = 0; possible && at < front.size(); ++at) {
      if (is_turn_to_poll(++turn)) poll_interruption();
      if (at + kFrontAhead < front.size()) mesh_.prefetch_twins({front[at + kFrontAhead], 0});
      possible = spread_from(front[at]);
    }
  }
  if (reached_)
    reached_->insert(reached_->end(), next_front_.begin(),
                     next_front_.begin() + static_cast<std::ptrdiff_t>(next_size_));
  return possible;
}

bool TriangleRoles::spread_from(FaceId face) {
  const Role role = this->role(face);
  const auto& roles_across = kRolesAcross[role];
  for (int side = 0; side < 3; ++side) {
    const FaceSide across = mesh_.twin({face, side});
    if (!across.exists()) {
      if (role == kMiddle || role == kFirstCorner + side)
        return fail({face, (side + 1) % 3}, "it and its neighbour on the border would both be new");
      continue;
    }
    const Role wanted =
        roles_across[static_cast<std::size_t>(side)][static_cast<std::size_t>(across.side())];
    const Role found = this->role(across.face());
    if (found != wanted && found != kUnknown)
      return fail({face, (side + 1) % 3},
                  "on one way it would be new, and on another one it would be kept");
    if (!set(across.face(), wanted)) return false;
  }
  return true;
}

bool TriangleRoles::find() {
  std::vector<FaceId> firsts;
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    if ((faces_[face] & kAllMayBeNew) != kAllMayBeNew) firsts.push_back(face);
  mesh_.sort_as_in_file(firsts);
  poll_interruption();
  for (const FaceId face : firsts) {
    if (role(face) != kUnknown) continue;
    const unsigned kept = kAllMayBeNew & ~unsigned{faces_[face]};
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
      smallest = std::min(smallest.value_or(kNoId), mesh_.file_vertex(kept_corner(face)));
    put(face, kUnknown);
  }
  return smallest;
}

/// Components whose vertices may all be new are tori and rings. The answers differ by a shift of
/// the mesh onto itself, so they are equally deep: the one that keeps the smallest vertex is taken.
bool TriangleRoles::find_in_regular_components() {
  std::vector<FaceSide> corner_of(mesh_.vertex_count());  // by the numbers of the file
  for (FaceId face = 0; face < mesh_.face_count(); ++face)
    for (int corner = 0; corner < 3 && role(face) == kUnknown; ++corner) {
      FaceSide& last = corner_of[mesh_.file_vertex({face, corner})];
      if (!last.exists() || mesh_.file_middle(last.face()) <= mesh_.file_middle(face))
        last = {face, corner};
    }
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
