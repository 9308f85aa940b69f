#include "surface/creases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::array<double, 4> kAngles = {60, 50, 40, 30};  ///< that are tried, in degrees
constexpr std::uint64_t kGapFactor = 8, kEdgesOfCorner = 3;
/// Numbers of a file are rounded, so an angle of exactly the limit can be a little more.
constexpr double kRoundingDegrees = 1e-3;
constexpr double kNoAngle = 180;
constexpr double kCornerCosine = std::numbers::sqrt2 / 2;  ///< of a crease that turns by 45 degrees

/// [3 face + side] in degrees; 0 at borders.
std::vector<double> edge_angles(const Surface& surface) {
  std::vector<double> angles(surface.across.size(), 0);
  for (FaceId face = 0; face < surface.faces.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      const FaceSide here(face, side), beyond = surface.across[here.code];
      if (!beyond.exists() || here.code > beyond.code) continue;
      const Point m = face_normal(surface, face), n = face_normal(surface, beyond.face());
      angles[here.code] = angles[beyond.code] =
          std::atan2(length(cross(m, n)), dot(m, n)) * kNoAngle / std::numbers::pi;
    }
  return angles;
}

/// Whether few edges turn by about the angle, so that those that turn further were drawn.
bool has_gap_at(const std::vector<double>& angles, double angle) {
  std::uint64_t sharp = 0, between = 0;
  for (const double each : angles) {
    sharp += each > angle ? 1u : 0u;
    between += each > angle / 2 && each <= angle ? 1u : 0u;
  }
  return sharp > 0 && kGapFactor * between <= sharp && 2 * sharp <= angles.size();
}

/// What a vertex has of creases.
struct VertexCreases {
  std::uint32_t count = 0;
  Point first{}, last{};  ///< of length 1, away from the vertex
  bool is_on_border = false;

  bool is_corner() const {
    return count > 0 && (count != 2 || is_on_border || dot(first, last) > -kCornerCosine);
  }
};

void find_corners(const Surface& surface, Creases& creases) {
  std::vector<VertexCreases> vertices(surface.positions.size());
  for (FaceId face = 0; face < surface.faces.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      const FaceSide here(face, side), beyond = surface.across[here.code];
      const VertexId start = surface.faces[face][static_cast<std::size_t>((side + 1) % 3)],
                     end = surface.faces[face][static_cast<std::size_t>((side + 2) % 3)];
      if (!beyond.exists()) vertices[start].is_on_border = vertices[end].is_on_border = true;
      if (creases.sides[here.code] == 0 || here.code > beyond.code) continue;
      const Point along = normalized(surface.positions[end] - surface.positions[start]);
      const auto add = [](VertexCreases& vertex, Point away) {
        (vertex.count == 0 ? vertex.first : vertex.last) = away;
        ++vertex.count;
      };
      add(vertices[start], along);
      add(vertices[end], Point{0, 0, 0} - along);
    }
  creases.corners.reserve(vertices.size());
  for (const VertexCreases& vertex : vertices)
    creases.corners.push_back(vertex.is_corner() ? 1 : 0);
  creases.corner_count = static_cast<std::uint64_t>(
      std::count(creases.corners.begin(), creases.corners.end(), std::uint8_t{1}));
}

Creases creases_beyond(double angle, const Surface& surface, const std::vector<double>& angles) {
  Creases creases;
  creases.angle = angle;
  creases.sides.reserve(angles.size());
  for (const double each : angles) creases.sides.push_back(each > angle ? 1 : 0);
  const auto sides = std::count(creases.sides.begin(), creases.sides.end(), std::uint8_t{1});
  creases.edge_count = static_cast<std::uint64_t>(sides) / 2;
  if (creases.edge_count > 0)
    find_corners(surface, creases);
  else
    creases.sides.clear();
  return creases;
}

}  // namespace

Creases find_creases(const Surface& surface, std::optional<double> angle) {
  if (angle && *angle >= kNoAngle) return {};
  const std::vector<double> angles = edge_angles(surface);
  if (angle) return creases_beyond(*angle, surface, angles);
  for (const double each : kAngles) {
    if (!has_gap_at(angles, each + kRoundingDegrees)) continue;
    Creases creases = creases_beyond(each + kRoundingDegrees, surface, angles);
    if (kEdgesOfCorner * creases.corner_count <= creases.edge_count) return creases;
  }
  return {};
}

Surface cut_at(const Surface& surface, const Creases& creases) {
  Surface result{{}, surface.faces, surface.across};
  // Corners that hang together around a vertex are one tree; its root is the smallest.
  std::vector<std::uint32_t> parent(surface.across.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t corner) {
    while (parent[corner] != corner) corner = parent[corner] = parent[parent[corner]];
    return corner;
  };
  const auto join = [&](FaceSide a, int i, FaceSide b, int j) {
    const std::uint32_t p = root(FaceSide(a.face(), (a.side() + i) % 3).code),
                        q = root(FaceSide(b.face(), (b.side() + j) % 3).code);
    parent[std::max(p, q)] = std::min(p, q);
  };
  for (FaceId face = 0; face < surface.faces.size(); ++face)
    for (int side = 0; side < 3; ++side) {
      const FaceSide here(face, side), beyond = surface.across[here.code];
      if (!creases.sides.empty() && creases.sides[here.code] != 0) {
        result.across[here.code] = FaceSide();
      } else if (beyond.exists() && here.code < beyond.code) {
        join(here, 1, beyond, 2);
        join(here, 2, beyond, 1);
      }
    }
  std::vector<VertexId> number(parent.size(), kNoId);
  for (std::uint32_t corner = 0; corner < parent.size(); ++corner) {
    VertexId& vertex = result.faces[corner / 3][corner % 3];
    VertexId& at_root = number[root(corner)];
    if (at_root == kNoId) {
      at_root = static_cast<VertexId>(result.positions.size());
      result.positions.push_back(surface.positions[vertex]);
    }
    vertex = at_root;
  }
  return result;
}

PLAIT_END_NAMESPACE
