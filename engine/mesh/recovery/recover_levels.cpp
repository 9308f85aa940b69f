#include "mesh/recovery/recover_levels.h"

#include <algorithm>
#include <utility>

#include "base/interruption.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// The mesh of the kept vertices. Its faces are those in the middles, in their order; corner x of a
/// face is across side x of the middle.
LevelMesh coarser(const LevelView& mesh, const TriangleRoles& roles) {
  HugeArray<FaceId> number(mesh.face_count());  // of the coarse face around a middle
  const std::size_t count = mesh.face_count() / 4;
  HugeArray<FaceId> middles(count + 1);
  // Without branches: whether a face is a middle is different from face to face.
  FaceId before = 0;
  for (FaceId face = 0; face < mesh.face_count(); ++face) {
    middles[before] = face;
    number[face] = before;
    before += roles.is_middle(face) ? 1u : 0u;
  }
  LevelMesh result;
  result.faces.resize(count);
  result.twins.resize(count);
  result.corners.resize(count);
  result.middles.resize(count);
  constexpr std::size_t kMiddlesAhead = 8;
  for (std::size_t face = 0; face < count; ++face) {
    if (is_turn_to_poll(face)) poll_interruption();
    if (face + kMiddlesAhead < count)
      for (int side = 0; side < 3; ++side) {
        const FaceSide near = mesh.twin({middles[face + kMiddlesAhead], side});
        mesh.prefetch_twins(near);
        mesh.prefetch_vertices(near);
      }
    const FaceId middle = middles[face];
    result.middles[face] = mesh.file_middle(middle);
    for (int side = 0; side < 3; ++side) {
      const auto at = static_cast<std::size_t>(side);
      const FaceSide corner = mesh.twin({middle, side});
      result.faces[face][at] = mesh.vertex(corner);
      result.corners[face][at] = mesh.finest_corner(corner).code;
      // The edge from corner side + 1 begins with a side of that corner's small triangle: the one
      // opposite its third vertex.
      const FaceSide kept = mesh.twin({middle, (side + 1) % 3});
      const FaceSide beyond = mesh.twin(turned(kept, 2));
      std::uint32_t& twin = result.twins[face][at];
      twin = kNoId;
      if (!beyond.exists()) continue;
      const FaceSide there = mesh.twin(turned(beyond, 2));  // beyond ends at a kept corner
      twin = FaceSide(number[there.face()], (there.side() + 1) % 3).code;
    }
  }
  return result;
}

/// Whether vertices name edges and faces: no vertex has itself, or another one twice, as its
/// neighbour. A base mesh must be so.
std::optional<RecoveryFailure> find_double_edge(const LevelView& mesh, const LevelMesh& level) {
  const std::vector<VertexId> doubtful = without_plain_fan(level.faces, mesh.vertex_count());
  if (doubtful.empty()) return std::nullopt;
  std::vector<VertexId> neighbour_of(mesh.vertex_count(), kNoId);
  std::vector<bool> done(mesh.vertex_count(), true);
  for (const VertexId vertex : doubtful) done[vertex] = false;
  const auto is_double = [&](VertexId vertex, FaceSide corner) {
    const VertexId neighbour = mesh.vertex(corner);
    return neighbour == vertex || std::exchange(neighbour_of[neighbour], vertex) == vertex;
  };
  std::vector<FaceId> faces_there;
  for (FaceId face = 0; face < mesh.face_count(); ++face)
    if (std::ranges::any_of(level.faces[face], [&](VertexId vertex) { return !done[vertex]; }))
      faces_there.push_back(face);
  mesh.sort_as_in_file(faces_there);
  for (const FaceId face : faces_there)
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
        return RecoveryFailure{mesh.file_vertex(first), faces, on_border,
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
    result.failure = find_double_edge(LevelView(mesh, next), next);
    if (result.failure) return result;
    result.meshes.push_back(std::move(next));
    result.had_choice |= had_choice;
    if (told) told(static_cast<int>(result.meshes.size()));
  }
  return result;
}

void walk_patches(const FinestMesh& mesh, std::span<const FaceSide> corners, int levels,
                  VertexId* vertices) {
  const LevelView view(mesh);
  const std::size_t size = std::size_t{1} << levels, count = (size + 1) * (size + 2) / 2;
  // The triangle (i, j), (i + 1, j), (i, j + 1) of each row j, at its first corner, and the place
  // of (i, j). All rows advance together: each of them waits for memory at every step.
  struct Row {
    FaceSide at;
    VertexId* to;
  };
  std::vector<Row> rows;
  rows.reserve(corners.size() * size);
  for (std::size_t patch = 0; patch < corners.size(); ++patch)
    rows.push_back({corners[patch], vertices + patch * count});
  // The triangle (i + 1, j + 1), (i, j + 1), (i + 1, j) is across side 0, at its first corner.
  for (std::size_t j = 1; j < size; ++j)
    for (std::size_t patch = 0; patch < corners.size(); ++patch) {
      const Row& below = rows[rows.size() - corners.size()];
      const FaceSide between = view.twin(below.at);
      rows.push_back({turned(view.twin(turned(between, 2)), 1), below.to + (size + 2 - j)});
    }
  for (Row& row : rows) *row.to++ = view.vertex(row.at);
  for (std::size_t i = 0; i < size; ++i) {
    const std::span<Row> longer = std::span(rows).first(corners.size() * (size - 1 - i));
    const std::span<Row> ending = std::span(rows).subspan(longer.size(), corners.size());
    for (Row& row : ending) {
      *row.to++ = view.vertex(turned(row.at, 1));
      if (i == 0) *row.to = view.vertex(turned(row.at, 2));  // the last corner
    }
    for (Row& row : longer) {
      *row.to++ = view.vertex(turned(row.at, 1));
      row.at = view.twin(row.at);
      view.prefetch_twins(row.at);
    }
    for (Row& row : longer) {
      row.at = turned(view.twin(turned(row.at, 1)), 2);
      view.prefetch_twins(row.at);
      view.prefetch_vertices(row.at);
    }
  }
}

PLAIT_END_NAMESPACE
