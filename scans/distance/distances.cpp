#include "distance/distances.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "base/threads.h"
#include "plait/error.h"
#include "surface/paced_ranges.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

// Samples of one thread at a time, and those between two calls of the callback. A sample far from
// the other surface takes up to a thousand times as long as one near it, and a cancel must not
// wait.
constexpr std::size_t kSamplesOfThread = 256;
constexpr Pace kPace{1024, 32768};

/// A number from 0 to 1 that depends on `seed` alone (splitmix64: G. Steele et al., 2014).
double uniform(std::uint64_t seed) {
  seed += 0x9e3779b97f4a7c15u;
  seed = (seed ^ seed >> 30) * 0xbf58476d1ce4e5b9u;
  seed = (seed ^ seed >> 27) * 0x94d049bb133111ebu;
  seed ^= seed >> 31;
  return static_cast<double>(seed >> 11) * 0x1p-53;
}

Point area_vector_of(const TriangleSet& set, FaceId face) {
  const auto& [a, b, c] = set.faces[face];
  return area_vector(set.positions[a], set.positions[b], set.positions[c]);
}

double degrees_between(Point a, Point b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
}

/// The value that so large a share of the values does not exceed.
double percentile(std::vector<float>& values, double share) {
  const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(at);
  std::nth_element(values.begin(), middle, values.end());
  return double{*middle};
}

/// A uniform point of a triangle, by two uniform numbers (G. Turk, "Generating random points in
/// triangles", Graphics Gems, 1990).
Point point_of(const TriangleSet& set, FaceId face, double u, double v) {
  const auto& [a, b, c] = set.faces[face];
  const double root = std::sqrt(u);
  return (1 - root) * set.positions[a] + (root * (1 - v)) * set.positions[b] +
         (root * v) * set.positions[c];
}

}  // namespace

Distances measure_distances(const TriangleSet& from, const TriangleTree& tree,
                            const TriangleSet& to, const DistanceOptions& options) {
  std::vector<double> areas(from.faces.size());  // running sums
  double sum = 0;
  for (std::size_t face = 0; face < areas.size(); ++face)
    areas[face] = sum += length(area_vector_of(from, static_cast<FaceId>(face)));
  if (!(sum > 0))
    throw Error(ErrorCode::kInvalidArgument, "distances: expected a surface with area, found none");

  const auto count = static_cast<std::size_t>(options.samples);
  std::vector<float> distances(count), angles(count);
  const auto face_of = [&](std::size_t i) {
    const double place =
        sum * (static_cast<double>(i) + uniform(3 * i)) / static_cast<double>(count);
    const auto found = std::upper_bound(areas.begin(), areas.end(), place);
    return static_cast<FaceId>(
        std::min<std::size_t>(static_cast<std::size_t>(found - areas.begin()), areas.size() - 1));
  };
  const auto sample_of = [&](FaceId face, std::size_t i) {
    return point_of(from, face, uniform(3 * i + 1), uniform(3 * i + 2));
  };
  const auto measure = [&](std::size_t first, std::size_t last) {
    FaceId hint = 0;
    for (std::size_t i = first; i < last; ++i) {
      const FaceId face = face_of(i);
      const Point p = sample_of(face, i);
      const ClosestPoint closest = tree.closest(p, hint);
      hint = closest.face;
      distances[i] = static_cast<float>(std::sqrt(closest.squared_distance));
      angles[i] = static_cast<float>(
          degrees_between(area_vector_of(from, face), area_vector_of(to, closest.face)));
    }
  };
  for_paced_ranges(
      count, kPace,
      [&](std::size_t done) {
        if (options.progress && !options.progress({options.phase, done, count}))
          throw Error(ErrorCode::kCancelled, "distances: cancelled");
      },
      [&](std::size_t first, std::size_t last) {
        const std::size_t parts = (last - first + kSamplesOfThread - 1) / kSamplesOfThread;
        each_on_workers(std::size_t{0}, parts, [&](std::size_t part) {
          const std::size_t start = first + part * kSamplesOfThread;
          measure(start, std::min(start + kSamplesOfThread, last));
        });
      });

  Distances result;
  result.samples = count;
  double squares = 0, total = 0, turns = 0;
  std::vector<FarSample> far;
  for (std::size_t i = 0; i < count; ++i) {
    const double distance = double{distances[i]};
    if (distance > options.far) far.push_back({sample_of(face_of(i), i), distance});
    squares += distance * distance;
    total += distance;
    turns += double{angles[i]};
    result.max = std::max(result.max, distance);
  }
  const auto all = static_cast<double>(count);
  result.rms = std::sqrt(squares / all);
  result.far_share = static_cast<double>(far.size()) / all;
  result.far_places = far_places(std::move(far), count);
  result.mean = total / all;
  result.mean_angle = turns / all;
  result.percentile_99 = percentile(distances, 0.99);
  result.percentile_99_9 = percentile(distances, 0.999);
  result.percentile_99_angle = percentile(angles, 0.99);
  return result;
}

SurfaceBox box_of(const TriangleSet& triangles) {
  if (triangles.faces.empty()) return {};
  Point low = triangles.positions[triangles.faces[0][0]], high = low;
  for (const auto& face : triangles.faces)
    for (const VertexId vertex : face)
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], triangles.positions[vertex][axis]);
        high[axis] = std::max(high[axis], triangles.positions[vertex][axis]);
      }
  return {low, high};
}

double diagonal_of(const TriangleSet& triangles) {
  const SurfaceBox box = box_of(triangles);
  return length(box.high - box.low);
}

double mean_edge_of(const TriangleSet& triangles) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles.faces)
    sum += length(triangles.positions[b] - triangles.positions[a]) +
           length(triangles.positions[c] - triangles.positions[b]) +
           length(triangles.positions[a] - triangles.positions[c]);
  return triangles.faces.empty() ? 0 : sum / (3 * static_cast<double>(triangles.faces.size()));
}

PLAIT_END_NAMESPACE
