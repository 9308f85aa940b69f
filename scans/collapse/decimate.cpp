#include "collapse/decimate.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collapse/collapsing_mesh.h"
#include "collapse/quadric.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr double kPointShare = 1e-3;  ///< of a vertex's area: keeps its quadric positive definite
constexpr double kBorderShare = 1;  ///< weight of a border's plane, in squared lengths of its edge

/// The limits of a pass. Each pass tries all edges that are left, with wider limits.
struct ShapeLimits {
  double least_quality;  ///< of a new face, unless the old face is worse
  double least_turn;     ///< cosine of the angle between the normals of a face before and after
  double least_cone;     ///< cosine of the angle between a new face's normal and the fan's
};
constexpr std::array<ShapeLimits, 3> kPasses = {
    {{0.2, 0.5, 0.5}, {0.1, 0.2, 0.2}, {0.02, 0.0, 0.0}}};

struct Candidate {
  float cost;
  FaceSide edge;
  std::uint32_t stamp;  ///< sum of the stamps of its ends

  friend bool operator<(const Candidate& a, const Candidate& b) {  // the cheapest is the largest
    return a.cost != b.cost ? a.cost > b.cost : a.edge.code > b.edge.code;
  }
};

class Decimator {
 public:
  Decimator(const Surface& scan, const DecimateOptions& options)
      : mesh_(scan),
        history_(scan.faces.size()),
        quadrics_(scan.positions.size()),
        stamps_(scan.positions.size(), 0),
        carried_(scan.faces.size()),
        waits_(3 * scan.faces.size(), 0),
        options_(options),
        first_faces_(scan.faces.size()) {
    normalise(scan);
    add_quadrics();
  }

  void run() {
    for (const ShapeLimits& limits : kPasses) {
      limits_ = limits;
      std::uint64_t before = 0;
      do {
        before = mesh_.live_faces();
        if (before <= options_.faces) return;
        fill_queue();
        empty_queue();
      } while (before - mesh_.live_faces() > before / 100);
    }
  }

  Decimated finish();

 private:
  void normalise(const Surface& scan);
  void add_quadrics();
  void fill_queue();
  void empty_queue();
  /// Values an edge anew, and puts it into the queue if it can collapse.
  void offer(FaceSide edge);
  void push(FaceSide edge);
  bool try_collapse(FaceSide edge);
  void shape_patch(const Patch& patch, PatchShape& shape) const;
  /// Whether the fan's faces fit the limits. Sets their area, and their worst quality.
  bool fan_fits(const Patch& patch, const PatchShape& shape);
  void share_area(const Patch& patch);
  void tell();

  CollapsingMesh mesh_;
  CollapseHistory history_;
  std::vector<Point> positions_;  ///< in diagonals of the scan, from its middle
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> stamps_;  ///< counts the changes of a vertex
  std::vector<float> carried_;         ///< [face] area of the scan that the face stands for
  std::vector<std::uint8_t> waits_;    ///< [side] whether the queue has the edge by this side
  std::vector<Candidate> queue_;
  DecimateOptions options_;
  std::uint64_t first_faces_;
  ShapeLimits limits_{};
  Point middle_{}, fan_normal_{};
  double diagonal_ = 1, fan_area_ = 0, fan_quality_ = 0;
  std::array<double, kMaxFan> face_areas_{};
  std::uint64_t pops_ = 0;
  DecimateLimits refused_;
  Patch patch_;
  PatchShape shape_;
};

void Decimator::normalise(const Surface& scan) {
  Point low = scan.positions.empty() ? Point{} : scan.positions[0], high = low;
  for (const Point& p : scan.positions)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  middle_ = 0.5 * (low + high);
  diagonal_ = length(high - low);
  if (!(diagonal_ > 0)) diagonal_ = 1;
  positions_.reserve(scan.positions.size());
  for (const Point& p : scan.positions) positions_.push_back((1 / diagonal_) * (p - middle_));
}

void Decimator::add_quadrics() {
  for (FaceId face = 0; face < first_faces_; ++face) {
    const auto& corners = mesh_.faces()[face];
    const Point a = positions_[corners[0]], b = positions_[corners[1]], c = positions_[corners[2]];
    const Point normal = area_vector(a, b, c);
    const double area = length(normal) / 2;
    carried_[face] = static_cast<float>(area);
    Quadric plane;
    plane.add_plane(normalized(normal), a, area / 3);
    for (const VertexId vertex : corners) {
      quadrics_[vertex] = quadrics_[vertex] + plane;
      quadrics_[vertex].add_point(positions_[vertex], kPointShare * area / 3);
    }
    for (int side = 0; side < 3; ++side) {
      const FaceSide edge(face, side);
      if (mesh_.across(edge).exists()) continue;
      const VertexId start = mesh_.start(edge), end = mesh_.end(edge);
      const Point along = positions_[end] - positions_[start];
      Quadric wall;
      wall.add_plane(normalized(cross(along, normal)), positions_[start],
                     kBorderShare * squared_length(along));
      quadrics_[start] = quadrics_[start] + wall;
      quadrics_[end] = quadrics_[end] + wall;
    }
  }
}

void Decimator::shape_patch(const Patch& patch, PatchShape& shape) const {
  for (int i = 0; i < patch.ring_size(); ++i)
    shape.ring[static_cast<std::size_t>(i)] = positions_[patch.ring[static_cast<std::size_t>(i)]];
  shape.kept = positions_[patch.kept];
  shape.gone = positions_[patch.gone];
  if (!patch.closed && !patch.border_edge) {
    shape.now = shape.kept;
    return;
  }
  const Point middle = 0.5 * (shape.kept + shape.gone);
  shape.now = (quadrics_[patch.kept] + quadrics_[patch.gone]).minimum(middle);
}

bool Decimator::fan_fits(const Patch& patch, const PatchShape& shape) {
  fan_area_ = 0;
  fan_quality_ = 1;
  fan_normal_ = {0, 0, 0};
  std::array<Point, kMaxFan> normals;
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i), after = static_cast<std::size_t>(patch.next(i));
    const Point a = shape.ring[at], b = shape.ring[after];
    const Point old = patch.is_at_gone(i) ? shape.gone : shape.kept;
    const Point before = area_vector(old, a, b), now = area_vector(shape.now, a, b);
    const double before_area = length(before), now_area = length(now);
    if (dot(before, now) < limits_.least_turn * before_area * now_area) return false;
    const double side = squared_length(b - a);
    const double quality = triangle_quality(
        now_area, side + squared_length(a - shape.now) + squared_length(b - shape.now));
    if (quality < limits_.least_quality) {
      const double earlier =
          triangle_quality(before_area, side + squared_length(a - old) + squared_length(b - old));
      if (!(quality > earlier)) return false;
    }
    fan_quality_ = std::min(fan_quality_, quality);
    normals[at] = now;
    face_areas_[at] = now_area / 2;
    fan_area_ += now_area / 2;
    fan_normal_ = fan_normal_ + now;
  }
  const double normal_length = length(fan_normal_);
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (dot(normals[at], fan_normal_) < limits_.least_cone * 2 * face_areas_[at] * normal_length)
      return false;
  }
  return fan_quality_ > 0;
}

void Decimator::offer(FaceSide edge) {
  if (!mesh_.gather(edge, patch_)) {
    ++refused_.by_topology;
    return;
  }
  shape_patch(patch_, shape_);
  if (!fan_fits(patch_, shape_)) {
    ++refused_.by_shape;
    return;
  }
  double carried = 0;
  for (int i = 0; i < patch_.faces; ++i)
    carried += double{carried_[patch_.corners[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch_.lost_faces; ++i)
    carried += double{carried_[patch_.lost[static_cast<std::size_t>(i)].face()]};
  const double distance =
      std::max(0.0, (quadrics_[patch_.kept] + quadrics_[patch_.gone]).at(shape_.now));
  const double stretch = carried / fan_area_;
  const double cost = distance * stretch * stretch / std::sqrt(fan_quality_);
  queue_.push_back({static_cast<float>(cost), edge, stamps_[patch_.kept] + stamps_[patch_.gone]});
  waits_[edge.code] = 1;
}

void Decimator::push(FaceSide edge) {
  const std::size_t size = queue_.size();
  offer(edge);
  if (queue_.size() > size) std::push_heap(queue_.begin(), queue_.end());
}

void Decimator::fill_queue() {
  queue_.clear();
  refused_ = {};
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (!mesh_.lives(face)) continue;
    for (int side = 0; side < 3; ++side) {
      const FaceSide edge(face, side), beyond = mesh_.across(edge);
      waits_[edge.code] = 0;
      if (!beyond.exists() || edge.code < beyond.code) offer(edge);
    }
  }
  std::make_heap(queue_.begin(), queue_.end());
}

void Decimator::share_area(const Patch& patch) {
  double carried = 0;
  for (int i = 0; i < patch.lost_faces; ++i)
    carried += double{carried_[patch.lost[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch.faces; ++i)
    carried += double{carried_[patch.corners[static_cast<std::size_t>(i)].face()]};
  for (int i = 0; i < patch.faces; ++i) {
    const auto at = static_cast<std::size_t>(i);
    carried_[patch.corners[at].face()] = static_cast<float>(carried * face_areas_[at] / fan_area_);
  }
}

bool Decimator::try_collapse(FaceSide edge) {
  if (!mesh_.gather(edge, patch_)) return false;
  shape_patch(patch_, shape_);
  if (!fan_fits(patch_, shape_)) return false;
  const auto plane = lay_out(patch_, shape_);
  if (!plane) return false;
  history_.add(patch_, *plane);
  share_area(patch_);
  mesh_.collapse(patch_);
  positions_[patch_.kept] = shape_.now;
  quadrics_[patch_.kept] = quadrics_[patch_.kept] + quadrics_[patch_.gone];
  ++stamps_[patch_.kept];

  const Patch done = patch_;  // offer() gathers others
  for (int i = 0; i < done.faces; ++i) {
    const FaceSide corner = done.corners[static_cast<std::size_t>(i)];
    for (const bool last : {false, true}) {
      if (last && (done.closed || i + 1 < done.faces)) continue;
      const FaceSide spoke(corner.face(), (corner.side() + (last ? 1 : 2)) % 3);
      const FaceSide beyond = mesh_.across(spoke);
      if (waits_[spoke.code] == 0 && (!beyond.exists() || waits_[beyond.code] == 0)) {
        push(spoke);
      } else if (beyond.exists() && waits_[spoke.code] != 0) {
        waits_[beyond.code] = 0;  // two edges became this one
      }
    }
  }
  return true;
}

void Decimator::tell() {
  if (!options_.progress) return;
  const std::uint64_t gone = first_faces_ - mesh_.live_faces();
  if (!options_.progress(
          {"base mesh", gone, first_faces_ - std::min(first_faces_, options_.faces)}))
    throw Error(ErrorCode::kCancelled, "remesh: cancelled, base mesh");
}

void Decimator::empty_queue() {
  while (mesh_.live_faces() > options_.faces && !queue_.empty()) {
    if (++pops_ % 4096 == 0) tell();
    std::pop_heap(queue_.begin(), queue_.end());
    const Candidate next = queue_.back();
    queue_.pop_back();
    if (waits_[next.edge.code] == 0 || !mesh_.lives(next.edge.face())) continue;
    waits_[next.edge.code] = 0;
    const VertexId start = mesh_.start(next.edge), end = mesh_.end(next.edge);
    // Costs mostly grow, so an edge that is not the cheapest any more waits with its old cost.
    if (stamps_[start] + stamps_[end] != next.stamp)
      push(next.edge);
    else
      try_collapse(next.edge);
  }
}

Decimated Decimator::finish() {
  Decimated result;
  if (mesh_.live_faces() > options_.faces + 1) {
    fill_queue();
    result.limits = refused_;
  }
  std::vector<VertexId> number(positions_.size(), kNoId);
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (!mesh_.lives(face)) continue;
    for (const VertexId vertex : mesh_.faces()[face]) number[vertex] = 0;
  }
  for (VertexId vertex = 0; vertex < number.size(); ++vertex) {
    if (number[vertex] == kNoId) continue;
    number[vertex] = static_cast<VertexId>(result.positions.size());
    result.positions.push_back(diagonal_ * positions_[vertex] + middle_);
  }
  for (FaceId face = 0; face < first_faces_; ++face) {
    if (!mesh_.lives(face)) continue;
    const auto& [a, b, c] = mesh_.faces()[face];
    result.faces.push_back({number[a], number[b], number[c]});
    result.scan_faces.push_back(face);
  }
  result.history = std::move(history_);
  return result;
}

}  // namespace

Decimated decimate(const Surface& scan, const DecimateOptions& options) {
  Decimator decimator(scan, options);
  decimator.run();
  return decimator.finish();
}

PLAIT_END_NAMESPACE
