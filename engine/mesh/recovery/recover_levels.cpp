#include "mesh/recovery/recover_levels.h"

#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The mesh of the kept vertices. Its faces are those in the middles, in their order; corner x of a
/// face is across side x of the middle.
LevelMesh coarser(const LevelView& mesh, const TriangleRoles& roles) {
  std::vector<FaceId> number(mesh.face_count(), kNoId);  // of the coarse face around a middle
  FaceId count = 0;
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    if (roles.is_middle(face)) number[face] = count++;
  LevelMesh result;
  result.twins.resize(count);
  result.corners.resize(count);
  for (FaceId middle = 0; middle < mesh.face_count(); ++middle) {
    if (!roles.is_middle(middle)) continue;
    for (int side = 0; side < 3; ++side) {
      const auto at = static_cast<std::size_t>(side);
      result.corners[number[middle]][at] = mesh.finest_corner(mesh.twin({middle, side})).code;
      // The edge from corner side + 1 begins with a side of that corner's small triangle: the one
      // opposite its third vertex.
      const FaceSide kept = mesh.twin({middle, (side + 1) % 3});
      const FaceSide beyond = mesh.twin(turned(kept, 2));
      std::uint32_t& twin = result.twins[number[middle]][at];
      twin = kNoId;
      if (!beyond.exists()) continue;
      const FaceSide there = mesh.twin(roles.kept_corner(beyond.face()));
      twin = FaceSide(number[there.face()], (there.side() + 1) % 3).code;
    }
  }
  return result;
}

/// Whether vertices name edges and faces: no vertex has itself, or another one twice, as its
/// neighbour. A base mesh must be so.
std::optional<RecoveryFailure> find_double_edge(const LevelView& mesh) {
  std::vector<VertexId> neighbour_of(mesh.vertex_count(), kNoId);
  std::vector<bool> done(mesh.vertex_count(), false);
  const auto is_double = [&](VertexId vertex, FaceSide corner) {
    const VertexId neighbour = mesh.vertex(corner);
    return neighbour == vertex || std::exchange(neighbour_of[neighbour], vertex) == vertex;
  };
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    for (int at = 0; at < 3; ++at) {
      const FaceSide first{face, at};
      const VertexId vertex = mesh.vertex(first);
      if (done[vertex]) continue;
      done[vertex] = true;
      FaceSide corner = first;
      std::uint32_t faces = 0;
      bool found = false, on_border = false;
      // Clockwise to a border, if there is one, and then counterclockwise over all faces.
      for (FaceSide before = first; before.exists();) {
        corner = before;
        before = mesh.twin(turned(corner, 2));
        if (!before.exists())
          on_border = true;
        else
          before = turned(before, 2);
        if (before == first) break;
      }
      const FaceSide begin = corner;
      while (corner.exists()) {
        ++faces;
        found |= is_double(vertex, turned(corner, 1));
        const FaceSide beyond = mesh.twin(turned(corner, 1));
        if (!beyond.exists()) found |= is_double(vertex, turned(corner, 2));
        corner = beyond.exists() ? turned(beyond, 1) : FaceSide();
        if (corner == begin) break;
      }
      if (found)
        return RecoveryFailure{vertex, faces, on_border,
                               "the next coarser mesh would have two edges between two vertices"};
    }
  return std::nullopt;
}

}  // namespace

RecoveredLevels recover_levels(const FinestMesh& mesh, int most_levels,
                               const std::function<void(int)>& told) {
  RecoveredLevels result;
  while (static_cast<int>(result.meshes.size()) < most_levels) {
    const LevelView view =
        result.meshes.empty() ? LevelView(mesh) : LevelView(mesh, result.meshes.back());
    LevelMesh next;
    bool had_choice = false;
    {
      TriangleRoles roles(view);
      if (!roles.find()) {
        result.failure = roles.failure();
        return result;
      }
      had_choice = roles.had_choice();
      next = coarser(view, roles);
    }
    result.failure = find_double_edge(LevelView(mesh, next));
    if (result.failure) return result;
    result.meshes.push_back(std::move(next));
    result.had_choice |= had_choice;
    if (told) told(static_cast<int>(result.meshes.size()));
  }
  return result;
}

void walk_patch(const FinestMesh& mesh, FaceSide corner, int levels, VertexId* vertices) {
  const auto across = [&](FaceSide side) {
    FaceSide twin;
    twin.code = mesh.twins[side.face()][static_cast<std::size_t>(side.side())];
    return twin;
  };
  const std::int64_t size = std::int64_t{1} << levels;
  for (std::int64_t j = 0; j < size; ++j) {
    FaceSide at = corner;  // the triangle (i, j), (i + 1, j), (i, j + 1), at its first corner
    *vertices++ = mesh.vertex(at);
    for (std::int64_t i = 0; i < size - j; ++i) {
      *vertices++ = mesh.vertex(turned(at, 1));
      if (i + 1 == size - j) break;
      // The triangle (i + 1, j + 1), (i, j + 1), (i + 1, j), at its first corner.
      const FaceSide between = across(at);
      if (i == 0) corner = turned(across(turned(between, 2)), 1);
      at = turned(across(turned(between, 1)), 2);
    }
    if (j + 1 == size) *vertices = mesh.vertex(turned(at, 2));
  }
}

PLAIT_END_NAMESPACE
