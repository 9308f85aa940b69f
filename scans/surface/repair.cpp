#include "surface/repair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "base/interruption.h"
#include "mesh/mesh_source.h"
#include "mesh/weld.h"
#include "plait/error.h"
#include "surface/edge_pairs.h"
#include "surface/hole_fill.h"
#include "surface/orient.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Faces = std::vector<std::array<VertexId, 3>>;

bool is_finite(const Point& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

class Repair {
 public:
  Repair(IndexedMesh mesh, std::string_view source)
      : source_(source),
        positions_(std::move(mesh.positions)),
        faces_(std::move(mesh.faces)),
        cut_faces_(std::move(mesh.cut_faces)) {
    list_.vertices = positions_.size();
    list_.faces = faces_.size();
    origin_.resize(positions_.size());
    std::iota(origin_.begin(), origin_.end(), VertexId{0});
    face_origin_.resize(faces_.size());
    std::iota(face_origin_.begin(), face_origin_.end(), FaceId{0});
  }

  Repaired run(const SurfaceRepairOptions& options) {
    remove_bad_faces();
    remove_duplicates();
    pair_sides();
    list_.turned_faces = orient_faces(faces_, across_, origin_, source_);
    if (split_vertices()) pair_sides();  // a slit of two edges closes
    if (options.min_component > 1) remove_small_components(options.min_component);
    if (options.fill_holes > 0) fill_holes(options.fill_holes);
    remove_unused_vertices();
    if (faces_.empty())
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: expected at least one face, found none that can stay", source_));
    Repaired result;
    result.seam_vertices = seam_vertices();
    result.surface = {std::move(positions_), std::move(faces_), std::move(across_)};
    result.origin = std::move(origin_);
    result.face_origin = std::move(face_origin_);
    result.list = list_;
    return result;
  }

 private:
  void remove_bad_faces();
  void remove_duplicates();
  void pair_sides() {
    const std::uint64_t shared = plait::pair_sides(positions_.size(), faces_, across_);
    if (first_pairs_) list_.non_manifold_edges = shared;
    first_pairs_ = false;
  }
  bool split_vertices();
  void remove_small_components(std::uint64_t least);
  void fill_holes(std::uint64_t most_edges);
  void fill_hole(const std::vector<FaceSide>& hole);
  void remove_unused_vertices();
  std::uint64_t seam_vertices() const;

  /// Keeps the faces that `stays` says. The pairs of sides stay valid: whole components go.
  template <class Stays>
  void keep_faces(Stays stays);

  VertexId corner(FaceId face, int corner) const {
    return faces_[face][static_cast<std::size_t>(corner % 3)];
  }
  FaceSide across(FaceId face, int side) const { return across_[FaceSide(face, side).code]; }
  void move_face(std::size_t from, std::size_t to) {
    faces_[to] = faces_[from];
    face_origin_[to] = face_origin_[from];
  }
  void resize_faces(std::size_t count) {
    faces_.resize(count);
    face_origin_.resize(count);
  }
  FaceId face_count() const { return static_cast<FaceId>(faces_.size()); }

  std::string_view source_;
  std::vector<Point> positions_;
  Faces faces_;
  std::vector<CutFace> cut_faces_;
  std::vector<FaceSide> across_;
  std::vector<VertexId> origin_;
  std::vector<FaceId> face_origin_;
  RepairList list_;
  bool first_pairs_ = true;
};

void Repair::remove_bad_faces() {
  std::vector<bool> finite(positions_.size());
  for (std::size_t vertex = 0; vertex < positions_.size(); ++vertex) {
    finite[vertex] = is_finite(positions_[vertex]);
    list_.not_finite_vertices += finite[vertex] ? 0u : 1u;
  }
  std::size_t kept = 0;
  for (std::size_t face = 0; face < faces_.size(); ++face) {
    if (is_turn_to_poll(face)) poll_interruption();
    const auto& [a, b, c] = faces_[face];
    for (const VertexId vertex : faces_[face])
      if (vertex >= positions_.size())
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: face {}: expected a vertex below {}, found {}", source_,
                                MeshSource(source_, cut_faces_).face(static_cast<FaceId>(face)),
                                positions_.size(), vertex));
    if (!finite[a] || !finite[b] || !finite[c]) {
      ++list_.not_finite_faces;
    } else if (a == b || b == c || c == a) {
      ++list_.degenerate_faces;
    } else {
      const Point normal = area_vector(positions_[a], positions_[b], positions_[c]);
      if (!(dot(normal, normal) > 0)) ++list_.needle_faces;
      move_face(face, kept++);
    }
  }
  resize_faces(kept);
}

void Repair::remove_duplicates() {
  // The faces whose smallest vertex is v are a list: first[v], then next[face].
  std::vector<FaceId> first(positions_.size(), kNoId), next(faces_.size());
  const auto sorted = [&](FaceId face) {
    auto corners = faces_[face];
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  std::vector<bool> stays(faces_.size(), true);
  for (FaceId face = 0; face < face_count(); ++face) {
    if (is_turn_to_poll(face)) poll_interruption();
    const auto corners = sorted(face);
    for (FaceId other = first[corners[0]]; other != kNoId && stays[face]; other = next[other])
      if (sorted(other) == corners) stays[face] = false;
    if (!stays[face]) {
      ++list_.duplicate_faces;
      continue;
    }
    next[face] = first[corners[0]];
    first[corners[0]] = face;
  }
  std::size_t kept = 0;
  for (std::size_t face = 0; face < faces_.size(); ++face)
    if (stays[face]) move_face(face, kept++);
  resize_faces(kept);
}

bool Repair::split_vertices() {
  std::vector<std::uint8_t> corner_seen(3 * faces_.size(), 0);
  std::vector<std::uint8_t> has_fan(positions_.size(), 0), counted(positions_.size(), 0);
  const auto after = [&](FaceSide corner) {
    const FaceSide beyond = across(corner.face(), (corner.side() + 1) % 3);
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 1) % 3) : FaceSide();
  };
  const auto before = [&](FaceSide corner) {
    const FaceSide beyond = across(corner.face(), (corner.side() + 2) % 3);
    return beyond.exists() ? FaceSide(beyond.face(), (beyond.side() + 2) % 3) : FaceSide();
  };
  bool any = false;
  for (FaceId face = 0; face < face_count(); ++face)
    for (int at = 0; at < 3; ++at) {
      if (is_turn_to_poll(face)) poll_interruption();
      const FaceSide start(face, at);
      if (corner_seen[start.code] != 0) continue;
      const VertexId vertex = corner(face, at);
      VertexId name = vertex;
      if (has_fan[vertex] != 0) {
        name = static_cast<VertexId>(positions_.size());
        positions_.push_back(Point(positions_[vertex]));
        origin_.push_back(origin_[vertex]);
        if (counted[vertex] == 0) ++list_.non_manifold_vertices;
        counted[vertex] = 1;
        any = true;
      }
      has_fan[vertex] = 1;
      FaceSide first = start;
      for (FaceSide c = before(start); c.exists() && c != start; c = before(c)) first = c;
      for (FaceSide c = first; c.exists() && corner_seen[c.code] == 0; c = after(c)) {
        corner_seen[c.code] = 1;
        faces_[c.face()][static_cast<std::size_t>(c.side())] = name;
      }
    }
  return any;
}

template <class Stays>
void Repair::keep_faces(Stays stays) {
  std::vector<FaceId> number(faces_.size(), kNoId);
  FaceId kept = 0;
  for (FaceId face = 0; face < face_count(); ++face)
    if (stays(face)) number[face] = kept++;
  for (FaceId face = 0; face < face_count(); ++face) {
    const FaceId to = number[face];
    if (to == kNoId) continue;
    move_face(face, to);
    for (int side = 0; side < 3; ++side) {
      const FaceSide beyond = across(face, side);
      across_[FaceSide(to, side).code] =
          beyond.exists() ? FaceSide(number[beyond.face()], beyond.side()) : FaceSide();
    }
  }
  resize_faces(kept);
  across_.resize(3 * faces_.size());
}

void Repair::remove_small_components(std::uint64_t least) {
  std::vector<std::uint32_t> component;
  const std::vector<std::uint64_t> sizes = face_components(faces_.size(), across_, component);
  for (const std::uint64_t size : sizes)
    if (size < least) {
      ++list_.small_components;
      list_.small_component_faces += size;
    }
  keep_faces([&](FaceId face) { return sizes[component[face]] >= least; });
}

void Repair::fill_holes(std::uint64_t most_edges) {
  std::vector<std::vector<FaceSide>> holes;
  for_each_border(faces_.size(), across_, [&](const std::vector<FaceSide>& border) {
    if (border.size() <= most_edges) holes.push_back(border);
  });
  for (const std::vector<FaceSide>& hole : holes) fill_hole(hole);
}

void Repair::fill_hole(const std::vector<FaceSide>& hole) {
  std::vector<VertexId> vertices;
  std::vector<Point> border;
  for (const FaceSide side : hole) {
    vertices.push_back(corner(side.face(), side.side() + 1));
    border.push_back(positions_[vertices.back()]);
  }
  const HoleFill fill = plait::fill_hole(border);
  for (const Point& p : fill.inner) {
    vertices.push_back(static_cast<VertexId>(positions_.size()));
    positions_.push_back(p);
    origin_.push_back(kNoId);
  }
  // The side that runs from a vertex of the fill to another one. The hole's own sides run along it.
  std::map<std::array<VertexId, 2>, FaceSide> sides;
  const auto count = static_cast<VertexId>(hole.size());
  for (VertexId i = 0; i < count; ++i) sides[{i, (i + 1) % count}] = hole[i];
  for (const auto& face : fill.faces) {
    const FaceId added = face_count();
    faces_.push_back({vertices[face[0]], vertices[face[1]], vertices[face[2]]});
    face_origin_.push_back(kNoId);
    across_.resize(3 * faces_.size());
    for (int side = 0; side < 3; ++side) {
      const FaceSide here(added, side);
      const VertexId start = face[static_cast<std::size_t>((side + 1) % 3)],
                     end = face[static_cast<std::size_t>((side + 2) % 3)];
      sides[{start, end}] = here;
      const auto beyond = sides.find({end, start});
      if (beyond == sides.end()) continue;
      across_[here.code] = beyond->second;
      across_[beyond->second.code] = here;
    }
  }
  ++list_.filled_holes;
  list_.filled_hole_faces += fill.faces.size();
}

void Repair::remove_unused_vertices() {
  std::vector<VertexId> number(positions_.size(), kNoId);
  poll_interruption();
  for (const auto& face : faces_)
    for (const VertexId vertex : face) number[vertex] = 0;
  VertexId kept = 0;
  for (std::size_t vertex = 0; vertex < positions_.size(); ++vertex) {
    if (number[vertex] == kNoId) {
      ++list_.unused_vertices;
      continue;
    }
    number[vertex] = kept;
    positions_[kept] = positions_[vertex];
    origin_[kept++] = origin_[vertex];
  }
  positions_.resize(kept);
  origin_.resize(kept);
  for (auto& face : faces_)
    for (VertexId& vertex : face) vertex = number[vertex];
}

std::uint64_t Repair::seam_vertices() const {
  std::vector<VertexId> on_border;
  for (FaceId face = 0; face < face_count(); ++face)
    for (int side = 0; side < 3; ++side)
      if (!across(face, side).exists())
        for (const int next : {1, 2}) on_border.push_back(corner(face, side + next));
  // A vertex that split_vertices() divided is one vertex of the file.
  const auto origin = [&](VertexId vertex) { return origin_[vertex]; };
  std::ranges::sort(on_border, {}, origin);
  const auto last = std::unique(on_border.begin(), on_border.end(),
                                [&](VertexId a, VertexId b) { return origin(a) == origin(b); });
  on_border.erase(last, on_border.end());
  return coinciding_vertices(positions_, on_border);
}

}  // namespace

bool RepairList::is_clean() const {
  return not_finite_vertices + degenerate_faces + duplicate_faces + non_manifold_edges +
             turned_faces + non_manifold_vertices + small_components + filled_holes +
             unused_vertices ==
         0;
}

Repaired repair(IndexedMesh mesh, const SurfaceRepairOptions& options, std::string_view source) {
  return Repair(std::move(mesh), source).run(options);
}

PLAIT_END_NAMESPACE
