#include "export/patch_selection.h"

#include <numeric>
#include <utility>

#include "plait/extend/edge_index.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

PatchSelection PatchSelection::part(std::vector<FaceId> faces) const {
  return {*base_, refinements_, std::move(faces), depths_ == nullptr ? nullptr : this};
}

PatchSelection::PatchSelection(const BaseMesh& base, int refinements, std::vector<FaceId> faces,
                               const PatchSelection* whole)
    : base_(&base),
      mesh_(base.topology()),
      depths_(base.depths()),
      refinements_(refinements),
      faces_(std::move(faces)),
      selected_(base.face_count()),
      number_(base.vertex_count(), kNoId) {
  for (const FaceId face : faces_) {
    selected_[face] = true;
    for (const VertexId vertex : mesh_.faces[face]) number_[vertex] = 0;
  }
  if (whole != nullptr) {
    others_ = whole->selected_;
    for (const FaceId face : faces_) others_[face] = false;
  }
  for (VertexId vertex = 0; vertex < number_.size(); ++vertex)
    if (number_[vertex] != kNoId) {
      number_[vertex] = static_cast<std::uint32_t>(vertices_.size());
      vertices_.push_back(vertex);
    }

  for (int level = 1; level <= (depths_ == nullptr ? 1 : std::max(refinements_, 1)); ++level)
    shapes_.push_back(make_shapes(level));
  first_ = {0, vertices_.size()};
  geometry_.emplace_back();
  for (int level = 1; level <= refinements_; ++level) {
    geometry_.emplace_back(shapes_at(level), BaseRelativeLevel(level), 1, 1);
    first_.push_back(first_.back() + geometry_.back().total_bytes());
  }
  if (depths_ == nullptr)
    triangle_count_ = faces_.size() << (2 * refinements_);
  else
    for (const FaceId face : faces_) triangle_count_ += drawn(face).triangle_count();
}

/// An edge of one selected patch is like a border edge: only half of its slot is in the part.
SlotShapes PatchSelection::make_shapes(int level) const {
  std::vector<EdgeId> half, absent;
  for (EdgeId edge = 0; edge < mesh_.edges.size(); ++edge) {
    const Edge& of = mesh_.edges[edge];
    const bool own = depths_ == nullptr ? contains(of.own) : has(of.own, of.other, level);
    const bool other = depths_ == nullptr ? contains(of.other) : has(of.other, of.own, level);
    if (!own && !other)
      absent.push_back(edge);
    else if (!own || !other)
      half.push_back(edge);
  }
  return {mesh_.edges.size(), EdgeSet(half), EdgeSet(absent)};
}

DrawnDepths PatchSelection::drawn(FaceId face) const {
  DrawnDepths drawn;
  drawn.face = depth(face);
  drawn.sides.fill(drawn.face);
  if (depths_ == nullptr) return drawn;
  for (int side = 0; side < 3; ++side)
    if (const FaceSide beyond = mesh_.across(FaceSide(face, side));
        contains(beyond) || is_in_other_part(beyond)) {
      int& there = drawn.sides[static_cast<std::size_t>(side)];
      there = std::max(there, depth(beyond.face()));
    }
  return drawn;
}

bool PatchSelection::has_own_face(EdgeId edge, BaseRelativeLevel level) const {
  return has(mesh_.edges[edge].own, mesh_.edges[edge].other, level.refinements);
}

std::uint64_t PatchSelection::number(const FaceIndex& point) const {
  if (is_corner(point.level, point.i, point.j))
    return number_[mesh_.faces[point.face][static_cast<std::size_t>(corner_of(point.i, point.j))]];
  const SideIndex at = to_side(point.level, point.i, point.j);
  const auto level = static_cast<std::size_t>(at.level);
  const EdgeId edge = mesh_.face_edges[point.face][static_cast<std::size_t>(at.side)];
  const Slot slot = geometry_[level].slot(edge);
  // A half slot is stored in the frame of its one face, which may be the one across the side.
  const bool turned = slot.shape == SlotShape::kWhole ? !mesh_.is_own(point.face, at.side)
                                                      : depth(point.face) < at.level;
  const std::int64_t last = slot_side(at.level) - 1;
  const std::int64_t position =
      turned ? slot_position(at.level, slot.shape, last - at.row, last - at.column)
             : slot_position(at.level, slot.shape, at.row, at.column);
  return first_[level] + slot.offset + static_cast<std::uint64_t>(position);
}

std::vector<FaceId> face_stretch(std::span<const FaceId> faces, std::uint64_t part,
                                 std::uint64_t parts) {
  const std::uint64_t first = faces.size() * part / parts;
  const std::uint64_t after = faces.size() * (part + 1) / parts;
  const std::span<const FaceId> stretch = faces.subspan(first, after - first);
  return {stretch.begin(), stretch.end()};
}

std::vector<FaceId> all_faces(const BaseMesh& base) {
  std::vector<FaceId> faces(base.face_count());
  std::iota(faces.begin(), faces.end(), FaceId{0});
  return faces;
}

PLAIT_END_NAMESPACE
