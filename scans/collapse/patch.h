// collapse/patch.h: the faces around an edge that shall collapse, and their place in the plane.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "plait/detail/namespace.h"
#include "surface/surface.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// The most faces that a collapse leaves at its vertex.
constexpr int kMaxFan = 28;

/// The faces at `kept` or `gone`, the ends of an edge. Their outer vertices are a ring, in
/// counterclockwise order. Face i has the ring's vertices i and i + 1 and one of the edge's ends,
/// and is still there after the collapse. At a border, the ring is open: it has one vertex more
/// than faces.
struct Patch {
  VertexId kept = kNoId, gone = kNoId;
  bool closed = true;
  /// Of an open ring: whether both ends are on the border, so that the edge is a border edge.
  bool border_edge = false;
  /// Whether the edge is a crease, and the places in the ring of the next vertices of its crease
  /// after `gone`, and after `kept` unless that is a corner. They are -1 otherwise.
  bool crease_edge = false;
  int crease_at_gone = -1, crease_at_kept = -1;
  /// Whether the fan's vertex is where `kept` was: on a border or a crease that `gone` is not on,
  /// or at a corner.
  bool kept_stays = false;
  int faces = 0;
  std::array<VertexId, kMaxFan + 1> ring{};
  std::array<FaceSide, kMaxFan> corners{};  ///< of face i at the edge's end
  std::uint32_t at_gone = 0;                ///< bit i: face i is at `gone`
  /// The faces that have both ends: their corner at `kept`, and the place of their third vertex in
  /// the ring. The first is left of the edge from `kept` to `gone`. A border edge has one.
  int lost_faces = 0;
  std::array<FaceSide, 2> lost{};
  std::array<int, 2> apex{};

  int ring_size() const { return closed ? faces : faces + 1; }
  int next(int i) const { return closed && i + 1 == faces ? 0 : i + 1; }
  bool is_at_gone(int face) const { return (at_gone >> face & 1u) != 0; }
};

struct PlanePoint {
  float x, y;
};
/// A point of the plane in computations; those of a patch are kept as PlanePoint.
struct PlaneVector {
  double x = 0, y = 0;
};

/// The ring in the plane around the new vertex, which is the origin, and the two old vertices
/// inside.
struct PatchPlane {
  std::array<PlanePoint, kMaxFan + 1> ring{};
  PlanePoint kept{}, gone{};
};

/// Which of the old vertices has the place of the new one.
enum class Anchor : std::uint8_t { kNone, kKept, kGone };

/// Positions in space of a patch before and after the collapse.
struct PatchShape {
  std::array<Point, kMaxFan + 1> ring{};
  Point kept{}, gone{}, now{};
  Anchor anchor = Anchor::kNone;  ///< of a border edge
};

/// Lays the fan out as a cone: angles at the new vertex are scaled so that their sum is a full
/// turn, at a border half a turn, and distances as a conformal map would (z to the power of the
/// scale). A crease that goes on at both ends of the edge is a straight line through the new
/// vertex, with half a turn on each side of it, and one that ends at a corner is a spoke of the new
/// vertex. The old vertices stay on it. The old vertices are placed by cotangent weights (U.
/// Pinkall and K. Polthier, "Computing discrete minimal surfaces and their conjugates", 1993), or
/// by mean value coordinates (M. Floater, 2003), or by equal weights: the first that turns no old
/// face and makes none a needle. Empty if none does.
std::optional<PatchPlane> lay_out(const Patch& patch, const PatchShape& shape);

PLAIT_END_NAMESPACE
