#include "execution/reader/bounds_tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

void unite(FaceBounds& with, const FaceBounds& more) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    with.low[axis] = std::min(with.low[axis], more.low[axis]);
    with.high[axis] = std::max(with.high[axis], more.high[axis]);
  }
}

bool is_empty(const FaceBounds& bounds, std::size_t axis) {
  return !(bounds.low[axis] <= bounds.high[axis]);
}

bool meets_box(const FaceBounds& bounds, const Box& box) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (is_empty(bounds, axis) || bounds.high[axis] < box.low[static_cast<int>(axis)] ||
        bounds.low[axis] > box.high[static_cast<int>(axis)])
      return false;
  return true;
}

/// The distance at which the ray enters the bounds; nothing if it misses them. (The slab method:
/// T. Kay and J. Kajiya, "Ray Tracing Complex Scenes", 1986.) A subtraction and a division are
/// rounded, so each distance may be wrong by a few units in its last place. The way out is made
/// longer by more than that, so that no ray slips past an edge (after T. Ize, "Robust BVH Ray
/// Traversal", 2013).
std::optional<double> enters(const FaceBounds& bounds, Vector3<double> origin,
                             Vector3<double> direction) {
  double near = 0, far = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double from = origin[static_cast<int>(axis)], along = direction[static_cast<int>(axis)];
    if (is_empty(bounds, axis)) return std::nullopt;
    const double low = bounds.low[axis], high = bounds.high[axis];
    if (along == 0) {
      if (from < low || from > high) return std::nullopt;
      continue;
    }
    const double in = ((along > 0 ? low : high) - from) / along;
    const double out = ((along > 0 ? high : low) - from) / along;
    near = std::max(near, in);
    far = std::min(far, out);
  }
  constexpr double kLonger = 1 + 8 * std::numeric_limits<double>::epsilon();
  if (far < 0 || near > far * kLonger + std::numeric_limits<double>::min()) return std::nullopt;
  return near;
}

void refuse_ray(std::string_view what, Vector3<double> found) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("find faces along a ray: expected {}, found ({}, {}, {})", what, found.x,
                          found.y, found.z));
}

bool is_finite_vector(Vector3<double> v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

BoundsTree::BoundsTree(std::vector<FaceBounds> faces) {
  nodes_.push_back(std::move(faces));
  while (nodes_.back().size() > 1) {
    const std::vector<FaceBounds>& below = nodes_.back();
    std::vector<FaceBounds> above;
    above.reserve((below.size() + kChildren - 1) / kChildren);
    for (std::size_t at = 0; at < below.size(); ++at)
      if (at % kChildren == 0)
        above.push_back(below[at]);
      else
        unite(above.back(), below[at]);
    nodes_.push_back(std::move(above));
  }
}

template <class Meets, class Visit>
void BoundsTree::search(std::size_t height, std::size_t node, const Meets& meets,
                        Visit& visit) const {
  const auto met = meets(nodes_[height][node]);
  if (!met) return;
  if (height == 0) return visit(static_cast<FaceId>(node), met);
  const std::size_t first = node * kChildren;
  const std::size_t last = std::min(first + kChildren, nodes_[height - 1].size());
  for (std::size_t child = first; child < last; ++child) search(height - 1, child, meets, visit);
}

std::vector<FaceId> BoundsTree::in_box(const Box& box) const {
  for (const Vector3<double>& corner : {box.low, box.high})
    if (std::isnan(corner.x) || std::isnan(corner.y) || std::isnan(corner.z))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("find faces in a box: expected numbers, found ({}, {}, {})", corner.x,
                              corner.y, corner.z));
  std::vector<FaceId> found;
  const bool empty = box.low.x > box.high.x || box.low.y > box.high.y || box.low.z > box.high.z;
  if (empty || nodes_.front().empty()) return found;
  auto visit = [&](FaceId face, bool) { found.push_back(face); };
  search(
      nodes_.size() - 1, 0, [&](const FaceBounds& of) { return meets_box(of, box); }, visit);
  return found;
}

std::vector<FaceOnRay> BoundsTree::along_ray(Vector3<double> origin,
                                             Vector3<double> direction) const {
  if (!is_finite_vector(origin)) refuse_ray("a finite origin", origin);
  if (!is_finite_vector(direction)) refuse_ray("a finite direction", direction);
  if (direction == Vector3<double>{0, 0, 0}) refuse_ray("a direction that is not zero", direction);
  std::vector<FaceOnRay> found;
  if (nodes_.front().empty()) return found;
  auto visit = [&](FaceId face, std::optional<double> distance) {
    found.push_back({face, *distance});
  };
  search(
      nodes_.size() - 1, 0, [&](const FaceBounds& of) { return enters(of, origin, direction); },
      visit);
  std::ranges::sort(found, [](const FaceOnRay& a, const FaceOnRay& b) {
    return std::tie(a.distance, a.face) < std::tie(b.distance, b.face);
  });
  return found;
}

PLAIT_END_NAMESPACE
